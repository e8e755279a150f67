"""Torques that are clipped."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.checks import clipped_torque

pytestmark = pytest.mark.slow


def test_torque_clipped_below_the_limit_is_reported(found, healthy) -> None:
    record = healthy("emps")
    level = 0.5 * float(np.abs(record.torque).max())
    texts = [finding.text for finding in found("emps", torque=np.clip(record.torque, -level, level))]
    assert any(
        f"the torque of motor_1 is clipped at {level:.6g} and -{level:.6g}, but the robot file allows 351.506" in text
        for text in texts
    )


def test_a_rounded_torque_has_flat_tops_that_are_not_clipped() -> None:
    """In the steps of a recorder a smooth extremum has equal samples, one step from those beside it."""
    smooth = 5.0 * np.sin(np.linspace(0.0, 6.0, 2000))
    assert clipped_torque._flat_tops(np.round(smooth, 3)) == []
    assert clipped_torque._flat_tops(np.round(np.minimum(smooth, 4.0), 3)) == [4.0]


def test_torque_at_the_limit_of_the_robot_is_reported_as_such(found, healthy) -> None:
    record = healthy("emps")
    torque = np.clip(3.0 * record.torque, -351.506, 351.506)
    texts = [finding.text for finding in found("emps", torque=torque)]
    assert any("the torque of motor_1 is at its limit" in text for text in texts)


def test_torque_beyond_the_limit_is_reported(found, healthy) -> None:
    texts = [finding.text for finding in found("emps", torque=5.0 * healthy("emps").torque)]
    assert any("but the robot file allows 351.506; the drive cuts it off" in text for text in texts)


def test_zero_torque_is_refused(found, healthy) -> None:
    findings = found("emps", torque=np.zeros_like(healthy("emps").torque))
    assert findings[0].hopeless
    assert findings[0].text.startswith("all torques are zero")


def test_steps_have_flat_tops_of_their_own(found, healthy) -> None:
    steps = 50.0 * np.sign(np.sin(np.arange(healthy("emps").n_samples) / 200))[:, None]
    assert not any("clipped" in finding.text for finding in found("emps", torque=steps))


def test_a_square_wave_beside_a_continuous_torque_is_not_clipped(found, healthy) -> None:
    torque = healthy("emps").torque.copy()
    level, third = 1.2 * float(np.abs(torque).max()), len(torque) // 3
    torque[:third, 0] = level * np.sign(np.sin(np.arange(third) / 200))
    assert not any("clipped" in finding.text for finding in found("emps", torque=torque))
