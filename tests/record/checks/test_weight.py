"""Torques without the weight of the arm."""

from __future__ import annotations

import numpy as np

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.checks.base import Finding
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.weight import Weight
from flexros.record.record import Record


def test_torques_without_weight_are_told(robots) -> None:
    """Moves of an upright arm; where the weight of one motor alone is missing, a spring may balance it."""
    robot, step = robots("elbow"), 0.01
    time = step * np.arange(1000)
    position = np.column_stack([0.8 * np.sin(1.3 * time), 1.0 * np.sin(0.9 * time)])
    stated, without = (
        rigid_inverse_dynamics(one, position, step, 4.0) for one in (robot, robot.with_values(WEIGHTLESS))
    )
    friction = 0.1 * stated.std(axis=0) * np.sign(np.gradient(position, axis=0))
    rng = np.random.default_rng(0)
    noisy = position + 1e-5 * rng.normal(size=position.shape)

    def findings(torque: np.ndarray) -> tuple[Finding, ...]:
        record = Record("log", step, noisy, torque + friction, np.ones(len(time), dtype=bool))
        return Weight().look(CheckedRecord(record, robot))

    (finding,) = findings(without)
    assert finding.hopeless
    assert finding.like_parameters
    assert "motor_1, motor_2 lacks the weight" in finding.text
    assert not findings(stated)
    assert not findings(np.column_stack([without[:, 0], stated[:, 1]]))
