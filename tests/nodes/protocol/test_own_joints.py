"""Measurements of other machines on the topic of the robot."""

from __future__ import annotations

import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros_nodes.protocol.own_joints import OwnJoints


def message(*names: str, stamp: int = 10**9) -> bytes:
    return JointStateTemplate(names, position=True).fill(stamp, position=[0.5] * len(names))


def test_joints_of_a_gripper_are_told_from_those_of_the_robot() -> None:
    own = OwnJoints(["motor_1", "motor_2"])
    for stamp in (10**9, 2 * 10**9):
        assert own.are_in(message("motor_1", "motor_2", stamp=stamp))
        assert not own.are_in(message("finger", stamp=stamp))
        assert own.are_in(message("motor_2", "finger", stamp=stamp))  # the reader says what it lacks
    assert own.foreign == 2


def test_message_without_joints_is_for_the_reader_to_reject() -> None:
    assert OwnJoints(["motor_1"]).are_in(message())


def test_bytes_that_are_no_joint_state_are_rejected() -> None:
    with pytest.raises(MessageError):
        OwnJoints(["motor_1"]).are_in(message("motor_1")[:20])
