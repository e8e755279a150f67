"""The servo of a motor: its place in the robot file, and the robot that is commanded by positions."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model
from tests.gap.servo_logs import servo_robot


def test_gains_are_parameters_with_units() -> None:
    parameters = servo_robot(0.5).parameters
    assert parameters["motor_1.servo_stiffness"].value == 60.0
    assert parameters["motor_1.servo_stiffness"].unit == "Nm/rad"
    assert parameters["motor_1.servo_damping"].unit == "Nm s/rad"
    assert parameters["motor_1.servo_feedforward"].value == 0.5


def test_robots_without_servo_keep_their_fingerprint() -> None:
    robot = load_robot("elbow")
    assert "servo" not in robot.spec.model_dump_json()
    assert not any("servo" in name for name in robot.parameters)


def test_input_is_kept_with_new_values_and_does_not_change_the_fingerprint() -> None:
    robot = servo_robot().commanded_by("position")
    stiffer = robot.with_values({"motor_1.servo_stiffness": 90.0})
    assert stiffer.commands == "position"
    assert stiffer.parameters["motor_1.servo_stiffness"].value == 90.0
    assert robot.model_hash == servo_robot().model_hash
    assert robot.commanded_by("position") is robot


def test_motor_without_servo_is_named() -> None:
    with pytest.raises(InputError, match=r"motor_1, motor_2.*servo: \{stiffness"):
        load_robot("elbow").commanded_by("position")


def test_linear_model_has_the_loop_closed() -> None:
    torque, position = (linear_model(servo_robot().commanded_by(kind)) for kind in ("torque", "position"))
    np.testing.assert_allclose(position.stiffness - torque.stiffness, [[60.0]])
    np.testing.assert_allclose(position.damping - torque.damping, [[2.0]])
    np.testing.assert_array_equal(position.input, torque.input)


def test_servo_of_emps_has_the_gains_of_its_controller() -> None:
    parameters = load_robot("emps_servo").parameters
    assert parameters["motor_1.servo_damping"].value == pytest.approx(243.45 * 35.1506, rel=1e-5)
    stiffness = parameters["motor_1.servo_stiffness"].value
    assert stiffness == pytest.approx(160.18 * 243.45 * 35.1506, rel=1e-5)
