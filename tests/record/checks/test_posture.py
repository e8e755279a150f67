"""Bases that are mounted otherwise than stated, and zeros elsewhere, as a user is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.checks.base import Finding
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.run import check_record, findings
from flexros.record.record import Record

STEP = 0.01


def _told(robots, gravity: tuple[float, float, float]) -> tuple[Record, tuple[Finding, ...]]:
    """Check a log of an elbow under gravity of another direction, with moves too slow to show more than weight."""
    robot = robots("elbow")
    time = STEP * np.arange(1500)
    position = np.column_stack([np.sin(0.7 * time) + 0.6 * np.sin(1.9 * time), np.cos(0.5 * time) - np.sin(1.3 * time)])
    other = robot.with_values(dict(zip(("gravity.x", "gravity.y", "gravity.z"), gravity, strict=True)))
    rng = np.random.default_rng(0)
    torque = rigid_inverse_dynamics(other, position, STEP, 4.0)
    torque += 0.1 * torque.std(axis=0) * (np.sign(np.gradient(position, axis=0)) + rng.normal(size=position.shape))
    noisy = position + 1e-5 * rng.normal(size=position.shape)
    record = Record("log", STEP, noisy, torque, np.ones(len(time), dtype=bool))
    return record, findings(record, robot)


def test_a_base_on_a_wall_is_refused_with_what_to_change(robots) -> None:
    """The first axis is across: a zero elsewhere at it is the same."""
    _, problems = _told(robots, (9.81, 0.0, 0.0))
    (text,) = [finding.text for finding in problems if finding.hopeless]
    assert "'gravity: [9.81, 0, 0]' in the robot file (how the base is mounted)" in text
    assert "+90 deg at motor_1 added" in text


def test_a_base_at_a_slant_is_refused_with_what_to_change(robots) -> None:
    record, problems = _told(robots, (6.94, 0.0, -6.94))
    (text,) = [finding.text for finding in problems if finding.hopeless]
    assert "is that of robot elbow in another posture" in text
    assert "'gravity: [6." in text
    with pytest.raises(InputError, match="in another posture"):
        check_record(record, robots("elbow"), parameters_known=False)


def test_weight_as_stated_is_no_finding(robots) -> None:
    _, problems = _told(robots, (0.0, 0.0, -9.81))
    assert not any("posture" in finding.text for finding in problems)
    record, _ = _told(robots, (0.0, 0.0, -9.81))
    inverted = findings(replace(record, torque=-record.torque), robots("elbow"))
    assert not any("posture" in finding.text for finding in inverted)


def test_a_motor_without_a_torque_says_nothing_of_the_posture(robots) -> None:
    """As of a joint whose motion is prescribed: its torque is zero, and over that of any size."""
    record, _ = _told(robots, (9.81, 0.0, 0.0))
    mute = CheckedRecord(replace(record, torque=record.torque * [1.0, 0.0]), robots("elbow"))
    with np.errstate(all="raise"):
        assert mute.postures == ()
