from __future__ import annotations

import math

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.trajectory.arc import circle
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.limits import Limits, check_limits, joint_limits
from flexros.trajectory.line import JointMove
from flexros.trajectory.polynomial import ninth_degree
from flexros.trajectory.sequence import Sequence
from flexros.trajectory.trajectory import JOINTS, Move, Trajectory


def one(path: object, law: object, output: str = "tool") -> Trajectory:
    return Trajectory((Move(path, law),), output)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [0.0, -2.0, math.nan])
def test_impossible_limits_are_refused_by_name(value: float) -> None:
    with pytest.raises(
        InputError, match=rf"the jerk limit is {value:g} \(unit of the path\)/s\^3, allowed is a finite"
    ):
        Limits(1.0, 1.0, value, 1.0)


def test_limits_along_a_circle_become_those_of_its_angle(start: FloatArray) -> None:
    limits = Limits(0.5, 15.0, 900.0, 54000.0).along(circle(start, 0.025))
    assert limits.values == pytest.approx((20.0, 600.0, 36000.0, 2.16e6))


def test_joint_limits_are_set_by_the_joint_that_needs_longest() -> None:
    move = JointMove(np.array([0.0, 0.0, 1.0]), np.array([2.0, -0.5, 1.0]))
    speed = np.array([3.0, 0.1, 1e-9])
    limits = joint_limits(move, (speed, np.array([4.0]), np.full(3, math.inf), np.array([8.0])))
    assert limits.values == pytest.approx((0.2, 2.0, math.inf, 4.0))


def test_joint_limits_need_one_value_per_joint() -> None:
    move = JointMove(np.zeros(3), np.ones(3))
    bound = np.array([1.0])
    with pytest.raises(
        InputError, match="there are 2 acceleration limits for 3 joints, allowed is one per joint or one"
    ):
        joint_limits(move, (bound, np.ones(2), bound, bound))


def test_negative_joint_limit_names_the_joint() -> None:
    with pytest.raises(InputError, match="the speed limit of joint 2 is -1 rad/s.* allowed is a finite number above 0"):
        joint_limits(JointMove(np.zeros(2), np.ones(2)), (np.array([1.0, -1.0]), *[np.array([1.0])] * 3))


def test_total_acceleration_of_the_circle_test(start: FloatArray) -> None:
    trajectory = one(circle(start, 0.025), bang_bang_snap(2 * np.pi, Limits(20.0, 600.0, 36000.0, 2.16e6)))
    check_limits(trajectory, Limits(speed=0.5 + 1e-9, acceleration=15.24))
    with pytest.raises(
        InputError,
        match=r"the acceleration reaches 15.23\d* m/s\^2 at t = .* s, .* % of move 1 \(path parameter .* rad\), "
        r"point \(.*\), "
        r"allowed are 15 m/s\^2 in all; slow the motion down by a factor 1.008",
    ):
        check_limits(trajectory, Limits(acceleration=15.0))


def test_corner_that_is_too_sharp_is_named() -> None:
    path = Sequence([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 0.01)
    trajectory = one(path, bang_bang_snap(path.extent, Limits(0.5, 5.0, 100.0, 5000.0)))
    with pytest.raises(InputError, match=r"the acceleration reaches .* 50.0 % of move 1 .* point \(0.99\d*, 0.00\d*\)"):
        check_limits(trajectory, Limits(acceleration=5.0), samples=4001)


def test_joints_are_checked_one_by_one() -> None:
    move = JointMove(np.zeros(2), np.array([1.0, 1.0]))
    trajectory = one(move, ninth_degree(1.0, 1.0), JOINTS)
    check_limits(trajectory, Limits(speed=2.47))
    with pytest.raises(InputError, match="the speed reaches 2.46094 rad/s at .* allowed are 2.4 rad/s in all"):
        check_limits(trajectory, Limits(speed=2.4))


def test_no_limits_need_no_check() -> None:
    check_limits(one(JointMove(np.zeros(2), np.ones(2)), ninth_degree(1.0, 1.0), JOINTS), Limits())
