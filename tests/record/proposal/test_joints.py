"""Joints of a bag as motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from flexros.errors import InputError
from flexros.record.proposal.joints import match_joints
from flexros.robot import load_robot, robot_from_data

if TYPE_CHECKING:
    from flexros.robot import Robot


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


def test_words_that_any_joint_may_have_do_not_matter() -> None:
    matches = match_joints(_elbow_with_joints("shoulder_joint", "elbow_joint"), ["elbow", "shoulder"], "table")
    assert [(m.joint, m.found) for m in matches] == [("shoulder", "own words"), ("elbow", "own words")]


def test_number_of_a_joint_is_its_name_beside_others_with_names() -> None:
    matches = match_joints(_elbow_with_joints("j1", "z"), ["z", "1"], "table")
    assert [(m.joint, m.found) for m in matches] == [("1", "own words"), ("z", "name")]


def test_numbers_from_zero_are_another_count() -> None:
    matches = match_joints(_elbow_with_joints("joint_1", "joint_2"), ["0", "1"], "table")
    assert [(m.joint, m.found) for m in matches] == [("0", "order"), ("1", "order")]
    with pytest.raises(InputError, match="none of them is joint_1, joint_2"):
        match_joints(_elbow_with_joints("joint_1", "joint_2"), ["0", "1", "2"], "table")


def test_capitals_of_a_name_do_not_matter() -> None:
    robot = _elbow_with_joints("Rotation", "FR_wristJaw2")
    matches = match_joints(robot, ["fr_wrist_jaw_2", "rotation"], "table")
    assert [(m.joint, m.found) for m in matches] == [("rotation", "name"), ("fr_wrist_jaw_2", "name")]


def test_capitals_behind_a_prefix_do_not_matter() -> None:
    matches = match_joints(_elbow_with_joints("Pitch", "Jaw"), ["arm_jaw", "arm_pitch"], "table")
    assert [(m.joint, m.found) for m in matches] == [
        ("arm_pitch", "end of the name"),
        ("arm_jaw", "end of the name"),
    ]


def test_a_name_alike_precedes_one_that_ends_alike() -> None:
    matches = match_joints(_elbow_with_joints("Pitch", "Wrist_Pitch"), ["wrist_pitch", "pitch"], "table")
    assert [m.joint for m in matches] == ["pitch", "wrist_pitch"]


def test_names_that_differ_in_capitals_alone_need_them() -> None:
    robot = _elbow_with_joints("jaw", "Jaw")
    assert [m.joint for m in match_joints(robot, ["Jaw", "jaw"], "bag")] == ["jaw", "Jaw"]
    with pytest.raises(InputError, match="none of them is Jaw"):
        match_joints(robot, ["jaw"], "table")


def _elbow_with_joints(first: str, second: str) -> Robot:
    robot = load_robot("elbow")
    tags = {"motor_1.joint": first, "motor_2.joint": second}
    return robot_from_data(robot.spec.model_copy(update={"tags": tags}).model_dump(), "elbow")
