"""Tolerances and outcome of a goal of FollowJointTrajectory."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros_nodes.protocol.reference.trajectory_goal import (
    Outcome,
    TrajectoryGoal,
    position_tolerances,
    refuse_component_tolerances,
)
from flexros_nodes.protocol.reference.trajectory_request import RejectedTrajectoryError, Rejection

NAMES = ("motor_1", "motor_2")
END = 2_000_000_000
ANY = np.full(2, np.inf)
NEAR = np.array([0.01, 0.1])
ZERO = np.zeros(2)


def tolerance(name: str, position: float, velocity: float = 0.0, acceleration: float = 0.0) -> Any:
    return SimpleNamespace(name=name, position=position, velocity=velocity, acceleration=acceleration)


def test_tolerances_are_in_the_order_of_the_motors() -> None:
    given = [tolerance("motor_2", 0.2, velocity=-1.0), tolerance("motor_1", 0.1)]
    assert position_tolerances(given, NAMES, "path_tolerance").tolist() == [0.1, 0.2]


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_zero_and_minus_one_are_no_tolerance(value: float) -> None:
    assert position_tolerances([tolerance("motor_2", value)], NAMES, "path_tolerance").tolist() == [math.inf, math.inf]


@pytest.mark.parametrize(
    ("given", "sentence", "refusal"),
    [
        (tolerance("wrist", 0.1), "goal_tolerance of wrist: allowed are motor_1, motor_2", Rejection.JOINTS),
        (tolerance("motor_1", math.nan), "of motor_1 is nan, allowed is a number above 0; 0 or -1", Rejection.POINTS),
        (tolerance("motor_1", -0.5), "of motor_1 is -0.5, allowed is a number above 0", Rejection.POINTS),
        (tolerance("motor_1", 0.1, velocity=1.0), "limits velocity or acceleration, allowed is", Rejection.POINTS),
        (tolerance("motor_1", 0.1, acceleration=1.0), "limits velocity or acceleration, allowed is", Rejection.POINTS),
    ],
)
def test_tolerance_that_cannot_be_kept_is_refused(given: Any, sentence: str, refusal: Rejection) -> None:
    with pytest.raises(RejectedTrajectoryError, match=sentence) as caught:
        position_tolerances([given], NAMES, "goal_tolerance")
    assert caught.value.reason is refusal


def test_tolerance_of_components_is_refused_and_not_ignored() -> None:
    refuse_component_tolerances([], "component_path_tolerance")
    given = SimpleNamespace(joint_name="motor_1", component=1, position=0.1)
    with pytest.raises(
        RejectedTrajectoryError, match="component_path_tolerance limits components of motor_1"
    ) as caught:
        refuse_component_tolerances([given], "component_path_tolerance")
    assert caught.value.reason is Rejection.POINTS


def test_goal_without_tolerances_is_reached_with_its_last_point() -> None:
    goal = TrajectoryGoal(NAMES, ANY, ANY, 0.0)
    assert goal.evaluate(END - 1, END, ZERO, np.array([9.0, 9.0])) is None
    verdict = goal.evaluate(END, END, ZERO, np.array([9.0, 9.0]))
    assert verdict is not None
    assert (verdict.outcome, verdict.text) == (Outcome.SUCCESSFUL, "")


def test_path_tolerance_counts_until_the_last_point() -> None:
    goal = TrajectoryGoal(NAMES, NEAR, ANY, 0.0)
    assert goal.evaluate(END - 1, END, ZERO, np.array([0.01, -0.1])) is None
    verdict = goal.evaluate(END - 500_000_000, END, ZERO, np.array([0.0, -0.25]))
    assert verdict is not None
    assert verdict.outcome is Outcome.PATH_TOLERANCE_VIOLATED
    assert verdict.text == (
        "motor_2 is 0.25 from its reference at stamp 1.5000 s, allowed is 0.1; the robot comes to rest"
    )
    after = goal.evaluate(END, END, ZERO, np.array([0.0, -0.25]))
    assert after is not None
    assert after.outcome is Outcome.SUCCESSFUL


def test_goal_tolerance_may_be_reached_within_the_goal_time() -> None:
    goal = TrajectoryGoal(NAMES, ANY, NEAR, 0.5)
    far, near = np.array([0.02, 0.0]), np.array([0.01, 0.0])
    assert goal.evaluate(END, END, ZERO, far) is None
    assert goal.evaluate(END + 500_000_000, END, ZERO, far) is None
    reached = goal.evaluate(END + 500_000_000, END, ZERO, near)
    missed = goal.evaluate(END + 500_500_000, END, ZERO, far)
    assert reached is not None
    assert reached.outcome is Outcome.SUCCESSFUL
    assert missed is not None
    assert missed.outcome is Outcome.GOAL_TOLERANCE_VIOLATED
    assert missed.text.startswith("0.5005 s after the last point motor_1 is 0.02 from its reference")


@pytest.mark.parametrize("goal_time", [0.0, -1.0])
def test_without_a_goal_time_the_goal_is_waited_for(goal_time: float) -> None:
    goal = TrajectoryGoal(NAMES, ANY, NEAR, goal_time)
    assert goal.evaluate(END + 10**15, END, ZERO, np.array([1.0, 1.0])) is None
