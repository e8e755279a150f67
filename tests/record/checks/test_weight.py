"""Torques without the weight of the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.checks.base import Finding
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.weight import Weight
from flexros.record.record import Record
from flexros.robot import Robot

T = 0.01


@dataclass(frozen=True, eq=False)
class Moves:
    """Moves of an upright arm, with the torques that they need with and without weight [Nm], shape (n, 2)."""

    robot: Robot
    position: FloatArray
    stated: FloatArray
    without: FloatArray

    def findings(self, torque: FloatArray) -> tuple[Finding, ...]:
        """Check torques with friction."""
        friction = 0.1 * self.stated.std(axis=0) * np.sign(np.gradient(self.position, axis=0))
        noise = 1e-5 * np.random.default_rng(0).normal(size=torque.shape)
        record = Record("log", T, self.position + noise, torque + friction, np.ones(len(torque), dtype=bool))
        return Weight().look(CheckedRecord(record, self.robot))


@pytest.fixture
def moves(robots) -> Moves:
    robot, time = robots("elbow"), T * np.arange(1000)
    position = np.column_stack([0.8 * np.sin(1.3 * time), 1.0 * np.sin(0.9 * time)])
    torques = [rigid_inverse_dynamics(one, position, T, 4.0) for one in (robot, robot.with_values(WEIGHTLESS))]
    return Moves(robot, position, *torques)


def test_torques_without_weight_are_told(moves: Moves) -> None:
    (finding,) = moves.findings(moves.without)
    assert finding.hopeless
    assert finding.like_parameters
    assert "motor_1, motor_2 lack the weight" in finding.text
    assert not moves.findings(moves.stated)


def test_a_motor_of_little_torque_may_leave_most_of_it(moves: Moves) -> None:
    """The model knows nothing of most of the torque of motor 2, which is little beside the weight."""
    power = np.mean(moves.without**2, axis=0)
    unknown = np.sqrt(power[0] / 4) * np.sin(11 * T * np.arange(len(moves.position)))
    assert np.mean(unknown**2) > power[1]
    (finding,) = moves.findings(moves.without + np.column_stack([np.zeros_like(unknown), unknown]))
    assert "lack the weight" in finding.text


def test_a_spring_may_balance_the_weight_of_one_motor(moves: Moves) -> None:
    assert not moves.findings(np.column_stack([moves.without[:, 0], moves.stated[:, 1]]))
    assert not moves.findings(np.column_stack([moves.stated[:, 0], moves.without[:, 1]]))


@pytest.mark.parametrize("share", [0.2, 0.5])
def test_weights_that_a_file_states_too_large_are_another_error(moves: Moves, share: float) -> None:
    assert not moves.findings(moves.without + share * (moves.stated - moves.without))
