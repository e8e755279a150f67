"""Joints of a bag as motors."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.record.proposal.joints import match_joints
from flexros.robot import load_robot


def test_order_of_the_messages_does_not_matter() -> None:
    matches = match_joints(load_robot("elbow"), ["motor_2", "gripper", "motor_1"], "bag")
    assert [(m.motor, m.joint, m.found) for m in matches] == [
        ("motor_1", "motor_1", "name"),
        ("motor_2", "motor_2", "name"),
    ]


def test_prefix_of_a_namespace() -> None:
    matches = match_joints(load_robot("elbow"), ["left/motor_1", "left/motor_2"], "bag")
    assert {m.found for m in matches} == {"end of the name"}


def test_unknown_names_by_order() -> None:
    matches = match_joints(load_robot("elbow"), ["a", "b"], "bag")
    assert [(m.motor, m.joint, m.found) for m in matches] == [("motor_1", "a", "order"), ("motor_2", "b", "order")]


def test_half_known_names_are_refused() -> None:
    with pytest.raises(InputError, match="motor_2"):
        match_joints(load_robot("elbow"), ["motor_1", "b"], "bag")
