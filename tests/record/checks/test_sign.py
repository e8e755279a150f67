"""Directions of torque and position of single motors."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("signal", ["torque", "position"])
def test_inverted_signal_of_a_single_axis_is_named(found, healthy, signal: str) -> None:
    findings = found("emps", **{signal: -getattr(healthy("emps"), signal)})
    assert findings[0].hopeless
    assert "torque" in findings[0].text
    assert "inverted" in findings[0].text


def test_all_torques_inverted(found, healthy) -> None:
    findings = found("e12", torque=-healthy("e12").torque)
    assert findings[0].hopeless
    assert "torque and motion of motor_1, motor_2 have opposite directions compared with robot e12" in findings[0].text
