"""Friction of unknown law: a curve over the speed, with sticking at its level of standstill."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects.friction.friction_curve import FrictionCurve
from flexros.effects.kinds.motor_law import MotorState

SIZES = {"standstill": 0.5, "speed_10": 1.0, "speed_25": 3.0, "speed_50": 2.0, "speed_75": 2.5, "speed_100": 4.0}


def added(speed: float, **sizes: float) -> float:
    """Return the smooth torque of a curve with its last knot at 2 rad/s [Nm]."""
    curve = FrictionCurve(speed=2.0, **sizes)
    motor = MotorState(ca.SX(0), ca.SX(0), ca.SX(speed), ca.SX(0))
    return float(curve.added(motor, curve.parameter_values))


@pytest.mark.parametrize(("speed", "torque"), [(0.0, 0.0), (0.2, 1.0), (0.35, 2.0), (0.5, 3.0), (2.0, 4.0), (9.0, 4.0)])
def test_torque_is_interpolated_between_knots_and_acts_against_both_directions(speed: float, torque: float) -> None:
    assert added(speed, **SIZES) == pytest.approx(-torque)
    assert added(-speed, **SIZES) == pytest.approx(torque)


@pytest.mark.parametrize(("speed", "torque"), [(0.5, 0.5), (1.0, 1.0), (1.5, 0.0), (2.0, -1.0)])
def test_uneven_friction_acts_alike_in_both_directions(speed: float, torque: float) -> None:
    for sign in (-1.0, 1.0):
        assert added(sign * speed, uneven_50=1.0, uneven_100=-1.0) == pytest.approx(-torque)


def test_torque_is_linear_in_its_sizes() -> None:
    parts = [added(0.7, **{name: size}) for name, size in SIZES.items()]
    assert sum(parts) == pytest.approx(added(0.7, **SIZES))


def test_level_at_standstill_sticks_in_both_directions() -> None:
    curve = FrictionCurve(**SIZES)
    levels = curve.levels(MotorState(ca.SX(0), ca.SX(0), ca.SX(0), ca.SX(0)), curve.parameter_values)
    np.testing.assert_allclose([float(levels.forward), float(levels.backward)], 0.5)


def test_curve_without_sizes_is_switched_off() -> None:
    assert FrictionCurve(speed=3.0).neutral
    assert not FrictionCurve(uneven_50=0.1).neutral
