"""Messages as columns: order of the joints, senders that change, messages that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.monitor.joint_messages import JointMessages
from flexros.robot import load_robot

NAMES = ("motor_1", "motor_2")


def states(names: tuple[str, ...], rows: list[tuple[float, ...]], first: int = 0) -> list[bytes]:
    template = JointStateTemplate(names, position=True)
    return [template.fill(10**9 + first + k, position=row) for k, row in enumerate(rows)]


@pytest.fixture
def reader() -> JointMessages:
    return JointMessages(load_robot("elbow"), "joint_states", "position")


def test_values_come_in_the_order_of_the_motors(reader: JointMessages) -> None:
    stamp, values = reader.take(states(NAMES[::-1], [(2.0, 1.0), (4.0, 3.0)]))
    np.testing.assert_array_equal(stamp, [10**9, 10**9 + 1])
    np.testing.assert_array_equal(values, [[1.0, 2.0], [3.0, 4.0]])


def test_senders_may_change_and_have_more_joints(reader: JointMessages) -> None:
    mixed = [
        *states(NAMES, [(1.0, 2.0)]),
        *states(("gripper", *NAMES), [(9.0, 3.0, 4.0)], 1),
        *states(NAMES, [(5.0, 6.0)], 2),
    ]
    np.testing.assert_array_equal(reader.take(mixed)[1], [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    assert reader.unusable == 0


def test_what_cannot_be_used_is_counted_and_said(reader: JointMessages) -> None:
    effort = JointStateTemplate(NAMES, effort=True).fill(5, effort=(1.0, 2.0))
    stamp, values = reader.take([b"", b"\x00\x01\x00\x00rubbish", effort, *states(("motor_7",), [(1.0,)])])
    assert (len(stamp), values.shape) == (0, (0, 2))
    assert reader.unusable == 4
    assert "motor_7" in reader.problem
    np.testing.assert_array_equal(reader.take(states(NAMES, [(1.0, 2.0)]))[1], [[1.0, 2.0]])


def test_nothing_gives_nothing(reader: JointMessages) -> None:
    assert reader.take([])[1].shape == (0, 2)


@pytest.mark.parametrize("first", ["states", "commands"])
def test_foreign_names_of_commands_are_matched_to_those_of_the_states(first: str) -> None:
    robot = load_robot("elbow")
    of_states = JointMessages(robot, "joint_states", "position")
    of_commands = JointMessages(robot, "joint_commands", "effort", of_states)
    command = JointStateTemplate(("elbow", "shoulder"), effort=True).fill(10**9, effort=(20.0, 10.0))
    if first == "commands":
        of_commands.take([command])
    of_states.take(states(("shoulder", "elbow"), [(1.0, 2.0)]))
    np.testing.assert_array_equal(of_commands.take([command])[1], [[10.0, 20.0]])
