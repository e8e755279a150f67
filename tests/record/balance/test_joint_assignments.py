"""Several axes that count the other way are found one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.balance import joint_assignments
from flexros.record.balance.joint_assignments import DOUBTFUL, JointAssignment, best_assignment, own_fits, score
from flexros.record.balance.spectra import torque_balance
from flexros.record.record import Record
from flexros.robot import load_robot
from tests.gap.rigid_arm import arm, motion, record_of_arm

RIGHT = np.array([1.0, 1.0, -1.0, -1.0, 1.0, -1.0])


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> Record:
    """A record whose positions are one where their sign is right and whose agreement is the share of right signs."""

    def share(balance: _Balance, n_motors: int) -> float:
        del n_motors
        return float(0.5 * np.mean(balance.position > 0))

    monkeypatch.setattr(joint_assignments, "torque_balance", lambda record, robot: _Balance(record.position[0]))
    monkeypatch.setattr(joint_assignments, "own_score", share)
    ones = np.ones((8, 6))
    return Record("log", 1e-3, RIGHT * ones, ones, np.ones(8, dtype=bool))


class _Balance:
    def __init__(self, position: FloatArray) -> None:
        self.position = position
        self.given = np.ones((1, len(position)))


def test_all_inverted_axes_are_named_as_a_hint(record: Record, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_assignments, "_assignments", lambda record, robot: iter(()))
    found = best_assignment(record, load_robot("six_axis"), 0.2)
    assert found is not None
    assert not found.clear  # an agreement of a half may have other reasons
    assert [name in found.text for name in load_robot("six_axis").joint_names] == (RIGHT < 0).tolist()


def test_of_assignments_that_fit_alike_the_first_is_told_with_the_others() -> None:
    """A wrist that is turned by half a turn moves as one whose next axis counts the other way."""
    zero, sign, worse = (
        JointAssignment(text, agreement, opposite=False)
        for text, agreement in (("+180 deg at motor_4 added", 0.951), ("motor_5 inverted", 0.95), ("exchanged", 0.9))
    )
    found = joint_assignments._first_of_alike([worse, sign, sign, zero])
    assert found.text == "motor_5 inverted (or, which fits as well, with +180 deg at motor_4 added)"
    assert joint_assignments._first_of_alike([worse, zero]).text == zero.text


def test_a_small_gain_is_no_hint(record: Record, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_assignments, "_assignments", lambda record, robot: iter(()))
    assert best_assignment(record, load_robot("six_axis"), 0.45) is None
    right = replace(record, position=RIGHT * record.position)
    assert best_assignment(right, load_robot("six_axis"), 0.4) is None


def test_zeros_of_another_model_of_the_robot_are_found() -> None:
    record = record_of_arm(imported=True)
    fits = own_fits(torque_balance(record, arm()), 2)
    right = score(fits)
    assert right is not None
    assert right > DOUBTFUL
    turned = replace(record, position=record.position + np.radians([90.0, -90.0]))
    found = best_assignment(turned, arm(), score(own_fits(torque_balance(turned, arm()), 2)))
    assert found is not None
    assert found.clear
    assert found.text == "the zero of the positions elsewhere, -90 deg at motor_1, +90 deg at motor_2 added"
    assert found.agreement == pytest.approx(right, abs=0.01)


def test_torques_without_the_weights_are_told() -> None:
    record, robot = record_of_arm(imported=True), arm()
    still, model = np.zeros(2), robot.model
    weights = [model.arm_inverse_dynamics(q, still, still, model.parameter_values).full().ravel() for q in motion()[0]]
    compensated = replace(record, torque=record.torque - weights)
    found = best_assignment(compensated, robot, score(own_fits(torque_balance(compensated, robot), 2)))
    assert found is not None
    assert not found.clear  # friction is most of what is left of these torques
    assert found.text.startswith("'gravity: [0, 0, 0]' in the robot file")
    assert best_assignment(record, robot, score(own_fits(torque_balance(record, robot), 2))) is None
