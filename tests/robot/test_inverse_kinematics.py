"""Inverse kinematics in general; the closed form is tested with the elbow."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import Robot, load_robot


@pytest.fixture(scope="module")
def six_axis() -> Robot:
    return load_robot("six_axis")


def _arm(robot: Robot, gears: list[float] | np.ndarray) -> np.ndarray:
    q = np.zeros(robot.n_arm)
    q[list(robot.gear_rows)] = gears
    return q


@pytest.mark.parametrize("roll", [3.0, 3.1, 3.2, 3.3, -3.2])
def test_roll_beyond_half_a_turn_stays_near(six_axis: Robot, roll: float) -> None:
    q = _arm(six_axis, [0, 0.2, 0.1, 0, 0.2, roll])
    near = _arm(six_axis, [0, 0.2, 0.1, 0, 0.2, roll - 0.3])
    target = six_axis.forward_kinematics(q, "tool")
    np.testing.assert_allclose(six_axis.inverse_kinematics(target, near, "tool"), q, atol=1e-9)


def test_poses_in_reach_are_found(six_axis: Robot) -> None:
    rng = np.random.default_rng(0)
    home = six_axis.home[list(six_axis.gear_rows)]
    for _ in range(40):
        q = _arm(six_axis, home + rng.uniform(-0.6, 0.6, 6))
        near = _arm(six_axis, q[list(six_axis.gear_rows)] + rng.uniform(-0.3, 0.3, 6))
        target = six_axis.forward_kinematics(q, "tool")
        found = six_axis.inverse_kinematics(target, near, "tool")
        np.testing.assert_allclose(six_axis.tool_pose(found)[:3], six_axis.tool_pose(q)[:3], atol=1e-9)


@pytest.mark.parametrize("target", [[1.0], [1.0, np.nan]])
def test_wrong_target_is_refused(target: list[float]) -> None:
    with pytest.raises(InputError, match="must be 2 finite numbers"):
        load_robot("e12").inverse_kinematics(target)
