"""Friction of unknown law over the motor position: a curve of levels."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects.friction.friction_over_position import FrictionOverPosition
from flexros.effects.kinds.motor_law import MotorState

CURVE = FrictionOverPosition(level_1=1.0, level_2=3.0, level_8=2.0, low=0.0, high=7.0)


def levels(curve: FrictionOverPosition, position: float) -> list[float]:
    """Return the levels of a curve against both directions [Nm]."""
    motor = MotorState(ca.SX(position), ca.SX(0), ca.SX(0), ca.SX(0))
    found = curve.levels(motor, curve.parameter_values)
    return [float(found.forward), float(found.backward)]


@pytest.mark.parametrize(
    ("position", "level"), [(-2.0, 1.0), (0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (1.5, 1.5), (6.5, 1.0), (9.0, 2.0)]
)
def test_level_is_interpolated_between_knots_and_constant_beyond_them(position: float, level: float) -> None:
    np.testing.assert_allclose(levels(CURVE, position), level)


def test_turned_round_it_is_the_same_friction_at_the_opposite_position() -> None:
    for position in (-1.0, 0.3, 1.7, 6.9):
        np.testing.assert_allclose(levels(CURVE.turned_round(), -position), levels(CURVE, position))


def test_curve_without_levels_is_switched_off() -> None:
    assert FrictionOverPosition(low=-3.0).neutral
    assert not CURVE.neutral
