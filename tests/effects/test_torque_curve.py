"""Torque of unknown law: a curve over the motor position."""

from __future__ import annotations

import casadi as ca
import pytest

from flexros.effects.kinds.motor_law import MotorState
from flexros.effects.torque_curve import TorqueCurve


@pytest.mark.parametrize(("angle", "torque"), [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (6.5, -1.0)])
def test_torque_is_interpolated_between_knots(angle: float, torque: float) -> None:
    assert _at(angle) == pytest.approx(torque)


@pytest.mark.parametrize(("angle", "torque"), [(-0.5, 0.0), (-1.0, -1.0), (-5.0, -1.0), (7.5, -3.0), (9.0, -4.0)])
def test_beyond_its_knots_it_goes_on_for_the_length_of_an_interval(angle: float, torque: float) -> None:
    """A cable pulls harder the farther a joint turns."""
    assert _at(angle) == pytest.approx(torque)


def _at(angle: float) -> float:
    curve = TorqueCurve(torque_1=1.0, torque_2=3.0, torque_8=-2.0, low=0.0, high=7.0)
    motor = MotorState(ca.SX(angle), ca.SX(0), ca.SX(0), ca.SX(0))
    return float(curve.added(motor, curve.parameter_values))
