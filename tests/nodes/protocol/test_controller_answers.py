"""Awaited commands of a fed controller, and their comparison with the recorded ones."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import RunError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.replay.controller_feed import ControllerFeed, ReferenceChunk
from flexros_nodes.protocol.controller_answers import FIRST_REPEAT, ControllerAnswers

NAMES = ("motor_1", "motor_2")
RECORDED = {10: (0.1, 0.2), 20: (0.3, 0.4)}
FEED = ControllerFeed((ReferenceChunk(0, 10, b"one"), ReferenceChunk(0, 30, b"two")), NAMES, RECORDED)
STATE, COMMAND = JointStateTemplate(NAMES, position=True), JointStateTemplate(NAMES, effort=True)


def state(stamp: int) -> bytes:
    return STATE.fill(stamp, (0.0, 0.0))


def command(stamp: int, *effort: float) -> bytes:
    return COMMAND.fill(stamp, effort=effort)


@pytest.fixture
def answers() -> ControllerAnswers:
    return ControllerAnswers(FEED, timeout=1.0)


def test_commands_are_compared_in_every_bit(answers: ControllerAnswers) -> None:
    nearly = float(np.nextafter(0.4, 1.0))
    for stamp, *effort in ((10, 0.1, 0.2), (20, 0.3, 0.4), (20, 0.3, nearly), (30, 0.0, 0.0)):
        answers.sent_state(state(stamp), 0.0)
        assert answers.waits
        assert answers.add_command(command(stamp, *effort))
        assert not answers.waits
    assert (answers.equal, answers.different, answers.unknown) == (2, 1, 1)


def test_commands_to_other_stamps_are_not_waited_for(answers: ControllerAnswers) -> None:
    answers.sent_state(state(20), 0.0)
    assert not answers.add_command(command(10, 0.1, 0.2))
    assert answers.waits
    assert answers.equal == 0


def test_without_a_command_measurement_and_chunks_go_out_again(
    answers: ControllerAnswers,
) -> None:
    answers.sent_chunk()
    answers.sent_chunk()
    answers.sent_state(state(20), 0.0)
    assert answers.to_repeat(0.5 * FIRST_REPEAT) == (b"", ())
    assert answers.to_repeat(1.5 * FIRST_REPEAT) == (state(20), (b"two",))
    assert answers.to_repeat(2.0 * FIRST_REPEAT) == (b"", ())
    assert answers.repeats == 1


def test_a_silent_controller_counts_as_gone(answers: ControllerAnswers) -> None:
    answers.sent_state(state(10), 0.0)
    with pytest.raises(RunError, match=r"no command for the measurement at stamp 0\.0000 s arrived within 1 s"):
        answers.to_repeat(1.1)


def test_messages_of_sensors_go_out_again_until_their_sample_is_answered(answers: ControllerAnswers) -> None:
    messages = {stamp: state(stamp) for stamp in (10, 20)}
    answers.sent_sensor(4, messages[10])
    answers.sent_state(state(10), 0.0)
    answers.sent_sensor(4, messages[20])
    assert answers.sensors_to_repeat == ((4, messages[10]), (4, messages[20]))
    answers.add_command(command(10, 0.1, 0.2))
    assert answers.sensors_to_repeat == ((4, messages[20]),)
