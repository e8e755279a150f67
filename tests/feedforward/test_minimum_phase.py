from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward import minimum_phase
from flexros.feedforward.minimum_phase import actuation_time, require_minimum_phase
from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot
from flexros.robot.linear.zeros import zero_dynamics
from flexros.trajectory import Trajectory
from tests.feedforward.cases import CIRCLE, SMOOTH, edited_robot, joint_trajectory, problem_of, tool_trajectory

pytestmark = pytest.mark.slow


def test_circle_test_is_minimum_phase(e12: Robot, circle: Trajectory) -> None:
    assert zero_dynamics(e12).minimum_phase
    require_minimum_phase(problem_of(e12, circle, 5e-4, 0.4))  # raises where it is not


def test_six_axis_pose_is_refused_before_time_stepping() -> None:
    robot = load_robot("six_axis")
    path = joint_trajectory(robot, [0.1] * 6, 1.0)
    sentence = (
        r"robot six_axis with output 'tool' at t = 0 s, gears at \[.*\] is non-minimum phase: "
        r"its zero dynamics have the unstable zero 5\d\d\.\d 1/s, .* choose another output"
    )
    with pytest.raises(InputError, match=sentence):
        compute_reference(robot, path, FeedforwardSpecification(output="tool", non_minimum_phase="refuse"), 5e-4, 1.1)


def test_complex_zeros_are_written_as_a_pair() -> None:
    def lighten(data: dict[str, list[dict[str, object]]]) -> None:
        data["bodies"][2]["inertia"] = {"yy": 0.5}
        data["bodies"][2]["center_of_mass"] = [0.15, 0, 0]

    robot = edited_robot("e12", lighten)
    assert not zero_dynamics(robot).minimum_phase
    with pytest.raises(InputError, match=r"robot e12 .* non-minimum phase: .* zero \d"):
        require_minimum_phase(problem_of(robot, joint_trajectory(robot, [0.1, 0.1], 0.5), 1e-3, 0.6, output="tool"))


def test_output_that_the_motors_do_not_move_is_refused(e12: Robot) -> None:
    def sideways(data: dict[str, object]) -> None:
        data["outputs"] = {"tool": {"pose": ["x", "y"]}}  # y is out of the plane of motion

    robot = edited_robot("e12", sideways)
    with pytest.raises(InputError, match=r"cannot be inverted: the motors do not move all components of the output"):
        require_minimum_phase(problem_of(robot, joint_trajectory(robot, [0.1, 0.1], 0.5), 1e-3, 0.6, output="tool"))


def test_motors_move_before_the_tool_by_the_slowest_unstable_zero() -> None:
    robot = load_robot("e12_long_tool")
    problem = problem_of(robot, tool_trajectory(robot, CIRCLE, SMOOTH), 5e-4, 0.9)
    assert actuation_time(problem) == pytest.approx(np.log(1e6) / 187.06423, rel=1e-5)


def test_nothing_moves_before_the_tool_of_a_minimum_phase_robot(e12: Robot, smooth: Trajectory) -> None:
    assert actuation_time(problem_of(e12, smooth, 5e-4, 0.9)) == 0.0


def test_a_slow_unstable_zero_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(minimum_phase, "LONGEST", 0.01)
    robot = load_robot("e12_long_tool")
    with pytest.raises(InputError, match=r"unstable zero of only 187.1 1/s, .* 0.07385 s before the tool"):
        actuation_time(problem_of(robot, tool_trajectory(robot, CIRCLE, SMOOTH), 5e-4, 0.9))
