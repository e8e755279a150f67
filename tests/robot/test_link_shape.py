"""Bars by which robots are seen."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot, robot_names
from flexros.robot.link_shape import BAR, STOREY, link_shapes, tool_offset


def test_bars_reach_from_joint_to_joint_and_to_the_tool() -> None:
    shapes = link_shapes(load_robot("e12").spec)
    assert [shape.end.tolist() for shape in shapes] == [[1, 0, 0], [1, 0, 0], [0.2, 0, 0]]
    assert tool_offset(load_robot("e12").spec).tolist() == [0.2, 0, 0]


def test_masses_without_lengths_lie_above_each_other() -> None:
    shapes = link_shapes(load_robot("four_mass").spec)
    assert [shape.start.tolist() for shape in shapes] == [[0, 0, 0], [0, 0, STOREY], [0, 0, 2 * STOREY]]
    assert all(shape.end[0] == BAR for shape in shapes)


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_can_be_seen(name: str) -> None:
    shapes = link_shapes(load_robot(name).spec)
    assert all(shape.radius > 0 and np.linalg.norm(shape.end - shape.start) > shape.radius for shape in shapes)
    assert shapes
