"""Commands read, or refused with a sentence."""

from __future__ import annotations

import pytest

from flexros.errors import RunError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros_nodes.protocol.loop.command_reader import CommandReader

NAMES = ("motor_1", "motor_2")


@pytest.fixture
def reader() -> CommandReader:
    return CommandReader(NAMES)


def test_effort_is_read(reader: CommandReader) -> None:
    message = JointStateTemplate(NAMES, effort=True).fill(10**9, effort=[1.5, -2.0])
    assert reader.read(message, 0).tolist() == [1.5, -2.0]


def test_joints_may_come_in_another_order(reader: CommandReader) -> None:
    message = JointStateTemplate(NAMES[::-1], effort=True).fill(10**9, effort=[1.5, -2.0])
    assert reader.read(message, 0).tolist() == [-2.0, 1.5]


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_torque_that_is_not_finite_is_refused(reader: CommandReader, bad: float) -> None:
    message = JointStateTemplate(NAMES, effort=True).fill(10**9, effort=[1.0, bad])
    with pytest.raises(
        RunError, match=r"sample 17 is rejected: its effort is \[1\.0, -?(nan|inf)\]; required is one finite"
    ):
        reader.read(message, 17)


def test_wrong_joint_name_is_refused(reader: CommandReader) -> None:
    message = JointStateTemplate(("motor_1", "elbow"), effort=True).fill(10**9, effort=[1.0, 2.0])
    with pytest.raises(RunError, match="lacks motor_2; it has motor_1, elbow"):
        reader.read(message, 0)


def test_wrong_size_is_refused(reader: CommandReader) -> None:
    message = JointStateTemplate(("motor_1",), effort=True).fill(10**9, effort=[1.0])
    with pytest.raises(RunError, match="lacks motor_2"):
        reader.read(message, 0)


def test_empty_effort_is_refused(reader: CommandReader) -> None:
    message = JointStateTemplate(NAMES, position=True).fill(10**9, position=[1.0, 2.0])
    with pytest.raises(RunError, match="its effort is empty"):
        reader.read(message, 0)


def test_bytes_that_are_no_message_are_refused(reader: CommandReader) -> None:
    with pytest.raises(RunError, match="sample 0 is rejected"):
        reader.read(b"\x00\x01\x00\x00\x01\x02", 0)


def command(effort: float, stamp: int = 10**9) -> bytes:
    return JointStateTemplate(NAMES, effort=True).fill(stamp, effort=[effort, 0.0])


def test_command_that_contradicts_the_one_taken_is_refused_when_two_nodes_send() -> None:
    reader = CommandReader(NAMES, lambda: 2)
    reader.read(command(1.0), 0)
    assert reader.stamp(command(1.0)) == 10**9
    with pytest.raises(RunError, match=r"two commands for stamp 1\.0000 s on joint_commands differ, and 2 nodes"):
        reader.stamp(command(2.0))


def test_second_controller_may_lag_by_some_samples() -> None:
    reader = CommandReader(NAMES, lambda: 2)
    for k in range(40):
        reader.read(command(1.0, 10**9 + k), k)
    with pytest.raises(RunError, match="a plant accepts one controller; stop the other"):
        reader.stamp(command(2.0, 10**9 + 30))
    assert reader.stamp(command(2.0, 10**9)) == 10**9  # long forgotten


def test_controller_alone_may_change_its_mind(reader: CommandReader) -> None:
    reader.read(command(1.0), 0)
    assert reader.stamp(command(2.0)) == 10**9
