"""Logs that the robot explains little of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.other_robot import OtherRobot
from flexros.record.record import Record
from flexros.robot import load_robot

PENDULUM = """
name: pendulum
defaults: {source: test, tolerance: 0.05}
gravity: [0, 0, -9.81]
bodies:
  - label: rod
    mass: 5
    center_of_mass: [0, 0, 0.3]
    inertia: {yy: 0.1}
    directions:
      ry: {spring: rigid, motor: {inertia: 0}}
outputs:
  tool: {pose: [x]}
  joints: {coordinates: [body_1.ry]}
controlled: joints
"""


@pytest.mark.parametrize(
    ("weight", "friction", "told"),
    [(1.2, 2.0, ""), (0.0, 9.0, "explains little of"), (0.0, 1.5, "is less than 20% of what the bodies of robot")],
)
def test_slow_motion_is_judged_by_its_weight(tmp_path: Path, weight: float, friction: float, told: str) -> None:
    """Of a motion of a quarter Hertz the spectra see friction and noise of the torque alone."""
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    robot = load_robot(str(tmp_path / "pendulum.yaml"))
    t = np.arange(0, 5, 2e-3)
    position = (0.8 * np.sin(2 * np.pi * 0.25 * t) + 0.002 * np.sin(2 * np.pi * (1 + t) * t))[:, None]
    torque = -weight * 9.81 * 1.5 * np.sin(position) + friction * np.sign(np.cos(2 * np.pi * 0.25 * t))[:, None]
    torque += 0.2 * np.random.default_rng(1).normal(size=torque.shape)
    position = position + 1e-7 * np.random.default_rng(2).normal(size=torque.shape)
    record = Record("log", 2e-3, position, torque, np.ones(len(t), dtype=bool), measured_torque=True, imported=True)
    texts = [finding.text for finding in OtherRobot().look(CheckedRecord(record, robot))]
    assert len(texts) == bool(told)
    assert not texts or told in texts[0]


@pytest.mark.slow
def test_torque_that_has_nothing_to_do_with_the_motion_is_told(found, healthy) -> None:
    record = healthy("e12")
    torque = np.cumsum(np.random.default_rng(1).normal(size=record.torque.shape), axis=0)
    torque *= record.torque.std(axis=0) / torque.std(axis=0)
    texts = [finding.text for finding in found("e12", torque=torque)]
    assert any("robot e12 explains little of the torque of motor_1, motor_2" in text for text in texts)


@pytest.mark.slow
def test_log_of_a_robot_alike_is_told(healthy) -> None:
    from flexros.record.checks.run import findings
    from flexros.robot import load_robot

    texts = [finding.text for finding in findings(healthy("elbow"), load_robot("e12"))]
    assert any("another robot" in text for text in texts)
