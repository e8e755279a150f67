"""Bars of the arm in space."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot, robot_from_data, robot_names
from flexros.robot.arm_view import ArmView


def state_of(q_a: list[float], q_m: list[float]) -> np.ndarray:
    q = np.array([*q_a, *q_m])
    return np.concatenate([q, np.zeros_like(q)])


def test_last_bar_ends_in_the_tool() -> None:
    robot = load_robot("e12")
    q_a = [0.1, 0.4, -0.2]
    bars = ArmView(robot).bars(state_of(q_a, [0.0, 0.0]), 5.0)
    np.testing.assert_allclose(bars.true[-1, 1], robot.tool_pose(q_a)[:3], atol=1e-14)
    np.testing.assert_allclose(bars.true[1:, 0], bars.true[:-1, 1], atol=1e-14)


def test_stiff_arm_follows_the_motors_and_the_magnified_one_goes_beyond() -> None:
    robot = load_robot("e12")
    q_a, q_m = [0.11, 0.42, -0.02], [0.1, 0.4]
    bars = ArmView(robot).bars(state_of(q_a, q_m), 10.0)
    np.testing.assert_allclose(bars.stiff[-1, 1], robot.tool_pose([0.1, 0.4, 0.0])[:3], atol=1e-14)
    np.testing.assert_allclose(bars.magnified[-1, 1], robot.tool_pose([0.2, 0.6, -0.2])[:3], atol=1e-14)


@pytest.mark.parametrize("name", robot_names())
def test_a_factor_of_one_shows_the_arm_as_it_is(name: str) -> None:
    robot = load_robot(name)
    state = np.random.default_rng(0).uniform(-1, 1, 2 * robot.n_coordinates)
    bars = ArmView(robot).bars(state, 1.0)
    np.testing.assert_allclose(bars.magnified, bars.true, atol=1e-12)
    lengths = np.linalg.norm(bars.stiff[:, 1] - bars.stiff[:, 0], axis=1)
    np.testing.assert_allclose(np.linalg.norm(bars.true[:, 1] - bars.true[:, 0], axis=1), lengths, atol=1e-12)


def test_body_before_the_first_joint_is_fixed_to_the_ground() -> None:
    data = load_robot("elbow").spec.model_dump(mode="json", exclude_unset=True)
    data["bodies"] = [{"label": "pedestal", "length": [0, 0, 0.5]}, *data["bodies"]]
    data["outputs"] = {"tool": {"pose": ["x", "z"]}}
    robot = robot_from_data({**data, "inverse_kinematics": "numerical"}, "elbow on a pedestal")
    bars = ArmView(robot).bars(state_of([0.2, 0.3], [0.2, 0.3]), 10.0)
    np.testing.assert_allclose(bars.true[0], [[0, 0, 0], [0, 0, 0.5]], atol=1e-14)
    np.testing.assert_allclose(bars.true[1, 0], [0, 0, 0.5], atol=1e-14)
    np.testing.assert_allclose(bars.true[-1, 1], robot.tool_pose([0.2, 0.3])[:3], atol=1e-14)
