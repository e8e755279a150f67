"""LQG: the poles of feedback and filter, integral action, and delay."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import linear_controller
from flexros.control.lqg import Lqg
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.control.loop_contexts import loop_of

LAW = Lqg(effort=0.5, torque_noise=1.0, moment_noise=10.0, torque_drift=20.0)


def test_loop_has_the_poles_of_feedback_and_filter() -> None:
    robot = load_robot("four_mass_linear")
    context = LAW.context(robot, robot.sample_time)
    plant = sampled_plants(linear_plants(robot), robot.sample_time, robot.delay)
    law, design = linear_controller(LAW, context), LAW.design(context)
    A, B, C = plant.A[0], plant.B[0], plant.C[0]
    loop = np.block([[A + B @ law.from_measured @ C, B @ law.from_state], [law.state_measured @ C, law.state_step]])
    n = design.model.size
    feedback = np.linalg.eigvals(A - B @ design.K[:, :n])
    filtered = np.linalg.eigvals(design.A - design.A @ design.L @ design.C)
    scale = 0.9 ** np.arange(len(loop) + 1)
    assert np.poly(loop) * scale == pytest.approx(np.poly(np.concatenate([feedback, filtered])) * scale, abs=1e-7)
    assert np.max(np.abs(np.linalg.eigvals(loop))) < 1.0


def test_a_constant_torque_leaves_no_error() -> None:
    step = [{"kind": "step", "at": "motor_1", "start": 0.5, "amplitude": 5.0}]
    changes = {"robot": "four_mass_linear", "noise": False, "duration": 6.0, "disturbances": step}
    scenario = load_scenario("four_mass_lqg").with_values(changes)
    position = closed_loop(
        Experiment.prepare(scenario.with_values({"controller.spring_segment": 0}))
    ).joint_states.position
    lazy = scenario.with_values({"controller.spring_segment": 0, "controller.torque_drift": 0.0})
    without = closed_loop(Experiment.prepare(lazy)).joint_states.position
    assert position is not None
    assert without is not None
    assert abs(position[-1, 0]) < 1e-6
    assert abs(without[-1, 0]) > 1e-3


def test_the_tool_acceleration_helps_the_filter() -> None:
    data = load_robot("four_mass_linear").spec.model_dump()
    data["sensors"]["tool_imu"] = {"acceleration": {"noise": 0.02, "axes": ["x"]}}
    from flexros.robot.robot import robot_from_data

    robot = robot_from_data(data, "test")
    more = LAW.model_copy(update={"measurements": ("motor_position", "tool_acceleration")})
    of_tool = [law.design(law.context(robot, 5e-4)) for law in (LAW, more)]
    errors = [
        design.model.F @ design.covariance[: design.model.size, : design.model.size] @ design.model.F.T
        for design in of_tool
    ]
    assert errors[1][0, 0] < 0.5 * errors[0][0, 0]


def test_missing_sensors_and_segments_are_refused() -> None:
    robot = load_robot("four_mass")
    context = LAW.context(robot, 5e-4)
    with pytest.raises(InputError, match="tool_imu"):
        LAW.model_copy(update={"measurements": ("tool_acceleration",)}).check(context)
    with pytest.raises(InputError, match="0 to 4"):
        LAW.model_copy(update={"spring_segment": 5}).check(context)


def test_a_motion_without_cost_is_refused() -> None:
    context = loop_of(LAW.model_copy(update={"motor_accuracy": 1e-3}), 3, 1e-3)
    with pytest.raises(InputError, match="motor_accuracy"):
        LAW.design(context)
