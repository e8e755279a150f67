"""Logs that the robot explains little of."""

from __future__ import annotations

import numpy as np
import pytest

pytestmark = pytest.mark.slow


def test_torque_that_has_nothing_to_do_with_the_motion_is_told(found, healthy) -> None:
    record = healthy("e12")
    torque = np.cumsum(np.random.default_rng(1).normal(size=record.torque.shape), axis=0)
    torque *= record.torque.std(axis=0) / torque.std(axis=0)
    texts = [finding.text for finding in found("e12", torque=torque)]
    assert any("robot e12 explains little of the torque of motor_1, motor_2" in text for text in texts)


def test_log_of_a_robot_alike_is_told(healthy) -> None:
    from flexros.record.checks.run import findings
    from flexros.robot import load_robot

    texts = [finding.text for finding in findings(healthy("elbow"), load_robot("e12"))]
    assert any("another robot" in text for text in texts)
