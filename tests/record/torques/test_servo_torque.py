"""Torque of the nominal servos, and records of logs without torques."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.log_record import log_record
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries
from flexros.record.read import read_record
from flexros.record.resampled import resampled
from flexros.record.torques.servo_torque import servo_torque
from tests.gap.servo_logs import ONE, T, servo_log, servo_robot


def test_torque_holds_the_link_at_rest_and_is_limited() -> None:
    log = servo_log()
    record = read_record(log, servo_robot(), name="log", positions=True)
    assert record.command is not None
    weight = 1.5 * 9.81 * 0.2 * np.sin(record.position[0, 0])
    assert record.torque[:50].mean() == pytest.approx(-weight, rel=0.02)
    limited = servo_torque(servo_robot(limit=0.3), record.command, record.position, T)
    assert np.abs(limited).max() == 0.3


def test_commands_are_taken_as_they_are_and_said_so() -> None:
    log = servo_log()
    record = read_record(log, servo_robot(), name="log", positions=True)
    assert log.joint_commands is not None
    np.testing.assert_array_equal(record.command, log.joint_commands.position)
    assert (record.commands, record.driven_by) == ("position", "commanded positions")
    assert record.driving is record.command
    assert any("joint_commands" in text and "servos" in text for text in record.warnings)


def test_references_are_the_commands_where_there_are_no_others() -> None:
    log = servo_log()
    moved = replace(log, joint_reference=log.joint_commands, joint_commands=None)
    record = read_record(moved, servo_robot(), name="log", positions=True)
    np.testing.assert_array_equal(record.command, log.joint_commands.position)  # type: ignore[union-attr]
    assert any("joint_reference" in text for text in record.warnings)


def test_torques_are_preferred_to_positions() -> None:
    log = servo_log()
    assert log.joint_commands is not None
    effort = np.random.default_rng(1).normal(size=log.joint_states.position.shape)  # type: ignore[union-attr]
    both = replace(log, joint_commands=replace(log.joint_commands, effort=effort))
    record = read_record(both, servo_robot(), name="log", positions=True)
    assert record.command is None
    np.testing.assert_array_equal(record.torque, effort)


def test_robot_without_servo_is_refused_with_the_key_to_add() -> None:
    with pytest.raises(InputError, match=r"log has position commands and no torques.*motor_1.*servo: "):
        read_record(servo_log(), servo_robot(servo=False), name="log", positions=True)


def test_identification_still_needs_torques() -> None:
    with pytest.raises(InputError, match="torques"):
        log_record(servo_log(), servo_robot(), name="log")


def test_commanded_speeds_are_kept() -> None:
    log = servo_log()
    assert log.joint_commands is not None
    rate = np.ones_like(log.joint_commands.position)
    record = read_record(
        replace(log, joint_commands=replace(log.joint_commands, velocity=rate)),
        servo_robot(),
        name="log",
        positions=True,
    )
    np.testing.assert_array_equal(record.command_rate, rate)


def test_parts_and_other_rates_have_their_commands() -> None:
    record = read_record(servo_log(), servo_robot(), name="log", positions=True)
    assert record.command is not None
    part = record.part(100, 200)
    np.testing.assert_array_equal(part.command, record.command[100:200])
    slower = resampled(record, 2 * T)
    assert slower.command is not None
    np.testing.assert_allclose(slower.command[:100], record.command[:200].reshape(100, 2).mean(axis=1)[:, None])


def test_commands_of_a_lower_rate_are_held() -> None:
    log = servo_log()
    assert log.joint_commands is not None
    assert log.joint_commands.position is not None
    slow = JointSeries(stamps_ns(len(log.joint_states.stamp), T)[::5], ONE, position=log.joint_commands.position[::5])
    record = read_record(replace(log, joint_commands=slow), servo_robot(), name="log", positions=True)
    assert record.command is not None
    np.testing.assert_allclose(record.command[:500], np.repeat(slow.position, 5, axis=0)[:500])  # type: ignore[arg-type]
