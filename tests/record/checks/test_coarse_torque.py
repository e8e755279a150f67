"""Torques that were recorded in coarse steps."""

from __future__ import annotations

import numpy as np


def test_coarse_steps_are_told(found, healthy) -> None:
    record = healthy("emps")
    step = 0.05 * float(np.sqrt(np.mean(record.torque**2)))
    rounded = step * np.round(record.torque / step)
    texts = [finding.text for finding in found("emps", torque=rounded, noted=rounded)]
    assert any(f"the torque of motor_1 was recorded in steps of {step:.3g}, 5 % of its rms" in text for text in texts)


def test_fine_steps_are_not(found, healthy) -> None:
    rounded = np.round(healthy("emps").torque, 4)
    texts = [finding.text for finding in found("emps", torque=rounded, noted=rounded)]
    assert not any("steps of" in text for text in texts)


def test_steps_are_those_of_the_recorder_and_not_of_the_means_of_samples(found, healthy) -> None:
    record = healthy("emps")
    step = 0.05 * float(np.sqrt(np.mean(record.torque**2)))
    noted = step * np.round(record.torque / step)
    mean = 0.5 * (noted + np.roll(noted, -1, axis=0))
    texts = [finding.text for finding in found("emps", torque=mean, noted=noted, measured_torque=True)]
    assert any(f"was recorded in steps of {step:.3g}," in text for text in texts)
