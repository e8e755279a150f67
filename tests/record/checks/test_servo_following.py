"""A motor under a servo moves with its command."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.record.checks.base import Finding
from flexros.record.checks.run import findings
from flexros.record.read import read_record
from flexros.record.record import Record
from tests.gap.servo_logs import servo_log, servo_robot


def record_with(factor: float = 1.0) -> Record:
    record = read_record(servo_log(), servo_robot(), name="log", positions=True)
    assert record.command is not None
    return replace(record, command=factor * record.command)


def found(record: Record) -> list[Finding]:
    return [one for one in findings(record, servo_robot()) if one.hopeless]


def test_a_servo_that_gives_way_is_no_problem() -> None:
    assert found(record_with()) == []


def test_inverted_commands_are_refused() -> None:
    (one,) = found(record_with(-1.0))
    assert "motor_1" in one.text
    assert "sign" in one.text


def test_commands_in_degrees_are_refused() -> None:
    (one,) = found(record_with(float(np.degrees(1.0))))
    assert "unit" in one.text


@pytest.mark.parametrize("factor", [0.45, 2.2])
def test_a_servo_that_is_held_back_or_overshoots_is_warned_of(factor: float) -> None:
    (one,) = (one for one in findings(record_with(1 / factor), servo_robot()) if "gear_ratio" in one.text)
    assert not one.hopeless
    assert "motor_1" in one.text


def test_a_soft_servo_that_does_not_follow_a_fast_chirp_is_no_error_of_units() -> None:
    """Below 1 Hz it follows; above, its inertia hardly moves."""
    record = record_with()
    assert record.command is not None
    time = record.sample_time * np.arange(record.n_samples)
    fast = np.sin(2 * np.pi * (2 + time / 4) * time)[:, None]
    assert found(replace(record, position=record.position + 0.05 * fast, command=record.command + fast)) == []


def test_a_gear_between_command_and_position_is_refused() -> None:
    (one,) = found(record_with(5.0))
    assert "gear" in one.text


def test_checks_of_torques_are_left_out() -> None:
    record = record_with()
    assert found(replace(record, torque=100.0 * record.torque)) == []
    assert found(replace(record, torque=100.0 * record.torque, command=None))
