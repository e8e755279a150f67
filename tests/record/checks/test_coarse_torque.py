"""Torques that were recorded in coarse steps."""

from __future__ import annotations

import numpy as np


def test_coarse_steps_are_told(found, healthy) -> None:
    record = healthy("emps")
    step = 0.05 * float(np.sqrt(np.mean(record.torque**2)))
    texts = [finding.text for finding in found("emps", torque=step * np.round(record.torque / step))]
    assert any(f"the torque of motor_1 was recorded in steps of {step:.3g}, 5 % of its rms" in text for text in texts)


def test_fine_steps_are_not(found, healthy) -> None:
    texts = [finding.text for finding in found("emps", torque=np.round(healthy("emps").torque, 4))]
    assert not any("steps of" in text for text in texts)
