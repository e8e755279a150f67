"""Poses of bodies."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot, robot_from_data
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.link_shape import tool_offset


def turned(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    u, w = quaternion[:3], quaternion[3]
    return vector + 2 * np.cross(u, np.cross(u, vector) + w * vector)


@pytest.mark.parametrize("name", ["e12", "elbow", "six_axis"])
def test_tool_is_in_the_frame_of_the_last_body(name: str) -> None:
    robot = load_robot(name)
    q_a = np.random.default_rng(1).uniform(-1, 1, robot.n_arm)
    *_, last = BodyPlacements(robot).poses(q_a)
    tool = robot.tool_pose(q_a)
    np.testing.assert_allclose(last[:3] + turned(last[3:], tool_offset(robot.spec)), tool[:3], atol=1e-12)
    np.testing.assert_allclose(abs(last[3:] @ tool[3:]), 1, atol=1e-12)


def test_body_on_the_ground_stays_there() -> None:
    data = load_robot("elbow").spec.model_dump(mode="json", exclude_unset=True)
    data["bodies"] = [{"label": "pedestal", "length": [0, 0, 0.5]}, *data["bodies"]]
    robot = robot_from_data({**data, "inverse_kinematics": "numerical"} | {"outputs": {"tool": {"pose": ["x"]}}}, "x")
    poses = BodyPlacements(robot).poses(np.array([0.2, 0.3]))
    assert poses[0].tolist() == [0, 0, 0, 0, 0, 0, 1]
    assert poses[1, :3].tolist() == [0, 0, 0.5]
