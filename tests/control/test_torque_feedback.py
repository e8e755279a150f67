"""Joint torque feedback: the poles of its state feedback, and lighter motors."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import linear_controller
from flexros.control.torque_feedback import TorqueFeedback
from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.robot import robot_from_data
from tests.control.loop_contexts import undamped

T = 1e-5
GAINS = {"kp": 5e4, "kd": 900.0, "kt": 1.5, "ks": 0.01}


def with_torque_sensor() -> Robot:
    data = undamped("two_mass").spec.model_dump()
    data["sensors"]["link"] = {"torque": {}}
    return robot_from_data(data, "test")


def test_loop_has_the_poles_of_its_gains() -> None:
    robot = with_torque_sensor()
    law = TorqueFeedback.model_validate(GAINS)
    controller = linear_controller(law, law.context(robot, T))
    plant = sampled_plants(linear_plants(robot), T, 0.0)
    k = robot.parameters["body_1.rz.stiffness"].value
    A, B = plant.A[0], plant.B[0]
    C = np.array([[0.0, 1.0, 0.0, 0.0], [-k, k, 0.0, 0.0]])  # states q_a, q_m and rates
    loop = np.block(
        [
            [A + B @ controller.from_measured @ C, B @ controller.from_state],
            [controller.state_measured @ C, controller.state_step],
        ]
    )
    found = np.log(sorted(np.linalg.eigvals(loop), key=abs)[-4:]) / T
    continuous, entry, *_ = linear_model(robot).matrices()
    kt, ks = GAINS["kt"] * k, GAINS["ks"] * k
    K = np.array([[-kt, GAINS["kp"] + kt, -ks, GAINS["kd"] + ks]])
    wanted = np.linalg.eigvals(continuous - entry @ K)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(wanted), rel=5e-3)


def test_robots_without_torque_sensors_are_refused() -> None:
    law = TorqueFeedback.model_validate(GAINS)
    with pytest.raises(InputError, match=r"sensors\.link\.torque"):
        law.check(law.context(load_robot("elbow"), 5e-4))
