"""Rejected trajectories and their messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
from flexros_nodes.protocol.reference.trajectory_request import (
    RejectedTrajectoryError,
    Rejection,
    check_points,
    in_joint_order,
    rest_row,
)

NAMES = ("motor_1", "motor_2")
NOW = 2_000_000_000


def trajectory(**changes: Any) -> JointTrajectoryChunk:
    given = {
        "stamp_ns": 0,
        "names": NAMES,
        "time_from_start": np.array([0, 10**9]),
        "positions": np.array([[0.0, 1.0], [2.0, -3.0]]),
    }
    return JointTrajectoryChunk(**{**given, **changes})


def nan_at(point: int, joint: int) -> np.ndarray:
    values = np.zeros((2, 2))
    values[point, joint] = np.nan
    return values


@pytest.mark.parametrize("stamp", [0, NOW - 10**9, NOW, NOW + 10**12])
def test_trajectory_that_is_not_over_is_allowed(stamp: int) -> None:
    check_points(trajectory(stamp_ns=stamp), NOW)


def test_joints_are_brought_into_order() -> None:
    ordered = in_joint_order(trajectory(names=("motor_2", "motor_1")), NAMES)
    assert ordered.positions is not None
    assert ordered.positions.tolist() == [[1.0, 0.0], [-3.0, 2.0]]


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("motor_1", "wrist"), "its joints are motor_1, wrist; allowed is each of motor_1, motor_2, once"),
        (("motor_1", "motor_1"), "its joints are motor_1, motor_1; allowed"),
    ],
)
def test_wrong_joints_are_refused(names: tuple[str, ...], said: str) -> None:
    with pytest.raises(RejectedTrajectoryError, match=said) as caught:
        in_joint_order(trajectory(names=names), NAMES)
    assert caught.value.reason is Rejection.JOINTS


@pytest.mark.parametrize("names", [(), ("motor_1",), (*NAMES, "wrist")])
def test_wrong_number_of_joints_is_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(RejectedTrajectoryError, match="allowed is each of motor_1, motor_2, once"):
        in_joint_order(trajectory(names=names, positions=np.zeros((2, len(names)))), NAMES)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"time_from_start": np.array([], np.int64), "positions": np.zeros((0, 2))}, "it has no points"),
        ({"time_from_start": np.array([5, 5])}, "its times do not increase from 0 on"),
        ({"time_from_start": np.array([5, 4])}, "its times do not increase from 0 on"),
        ({"time_from_start": np.array([-5, 4])}, "its times do not increase from 0 on"),
        ({"positions": None, "velocities": np.zeros((2, 2))}, "it has no positions"),
        ({"positions": nan_at(1, 0)}, r"points\[1\].positions of motor_1 is nan, allowed is a finite number"),
        ({"velocities": nan_at(0, 1)}, r"points\[0\].velocities of motor_2 is nan"),
        ({"effort": nan_at(1, 1)}, r"points\[1\].effort of motor_2 is nan"),
        (
            {"positions": np.array([[0.0, 0.0], [1.0, -180.0]])},
            r"points\[1\].positions of motor_2 is -180, allowed is up",
        ),
    ],
)
def test_points_that_cannot_be_followed_are_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(RejectedTrajectoryError, match=sentence) as caught:
        check_points(trajectory(**changes), NOW, position_limit=10.0)
    assert caught.value.reason is Rejection.POINTS


def test_trajectory_that_is_over_is_refused() -> None:
    with pytest.raises(RejectedTrajectoryError, match="give a later header.stamp, or 0 for now") as caught:
        check_points(trajectory(stamp_ns=NOW - 10**9 - 1), NOW)
    assert caught.value.reason is Rejection.TOO_LATE


def test_rest_row_keeps_the_torque() -> None:
    assert rest_row(np.array([1.0, 2.0, 3.0]), 0.5).tolist() == [1.5, 0.0, 3.0]
