"""Directions of torque and position of single motors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from flexros.record.balance.joint_assignments import JointAssignment
from flexros.record.balance.torque_balance import BalanceFit
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.sign import CLEAR, Sign

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


def test_inverted_torque_sensors_are_found_below_their_noise(found, healthy, robots) -> None:
    """A sensor behind the gear counts the load, and shows noise alone above the slow motion that carries it."""
    record = healthy("elbow")
    noise = np.random.default_rng(0).normal(size=record.torque.shape) * record.torque.std(axis=0)
    slow = sosfiltfilt(butter(2, 6.0 * record.sample_time, output="sos"), record.torque, axis=0)
    noisy = replace(record, torque=0.3 * noise - slow)
    fits = CheckedRecord(noisy, robots("elbow")).own
    assert all(fit.agreement < CLEAR for fit in fits if fit is not None)
    findings = found("elbow", noisy)
    assert findings[0].hopeless
    assert "motor_1, motor_2 have opposite directions" in findings[0].text
    assert not any("opposite" in finding.text for finding in found("elbow", replace(noisy, torque=-noisy.torque)))


@pytest.mark.parametrize(("share", "inverted"), [(0.3, True), (0.01, False)])
def test_what_little_friction_leaves_shows_no_sign(robots, healthy, share: float, inverted: bool) -> None:
    class Checked(CheckedRecord):
        own = (BalanceFit(-6.0, 0.2, -0.1, -0.95, share), BalanceFit(1.0, 0.9, 0.9, 0.9, 0.5))
        order_is_wrong, wrongly_assigned, assignment = False, False, None

    findings = Sign().look(Checked(healthy("elbow"), robots("elbow")))
    assert [finding.hopeless for finding in findings] == [True] * inverted
    assert all("motion of motor_1 have" in finding.text for finding in findings)


@pytest.mark.parametrize(("correlation", "inverted"), [(-0.51, False), (-0.85, True)])
def test_bands_that_agree_though_the_whole_torque_does_not_show_no_sign(
    robots, healthy, correlation: float, inverted: bool
) -> None:
    """Masses that are wrong turn the torque of a light joint round in some bands."""

    class Checked(CheckedRecord):
        own = (BalanceFit(-2.0, 0.6, -0.3, correlation, 0.8), BalanceFit(1.0, 0.9, 0.9, 0.9, 0.5))
        order_is_wrong, wrongly_assigned, assignment = False, False, None

    assert len(Sign().look(Checked(healthy("elbow"), robots("elbow")))) == inverted


@pytest.mark.parametrize(("agreement", "named"), [(0.4, False), (0.05, True)])
def test_a_better_assignment_comes_before_inverted_torques(robots, healthy, agreement: float, named: bool) -> None:
    """The zero of a joint elsewhere turns the weight that others carry round."""

    class Checked(CheckedRecord):
        own = (BalanceFit(-2.0, 0.6, -0.3, -0.95, 0.8), BalanceFit(-1.0, 0.4, 0.1, 0.5, 0.5))
        order_is_wrong, wrongly_assigned = False, False
        assignment = JointAssignment("the zero elsewhere", agreement, opposite=False, clear=False)

    assert len(Sign().look(Checked(healthy("elbow"), robots("elbow")))) == named


def test_torque_of_friction_that_brakes_the_wrong_way_is_named(found, healthy, robots, scaled) -> None:
    """A light joint moves against friction alone, in which the model has no part: its sign is all that shows."""
    record = healthy("elbow")
    speed = CheckedRecord(record, robots("elbow")).motion[1][:, 1]
    friction = 20 * np.abs(record.torque[:, 1]).max() * np.tanh(speed / speed.std())
    torque = np.column_stack([record.torque[:, 0], record.torque[:, 1] + friction])
    assert not any(finding.hopeless for finding in found("elbow", torque=torque))
    findings = found("elbow", torque=scaled(torque, 1, -1.0))
    assert findings[0].hopeless
    assert "torque of motor_2 brakes the motion" in findings[0].text
    assert "(--prescribed motor_2)" in findings[0].text
    assert "motor_1" not in findings[0].text
