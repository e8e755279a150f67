"""The hump of friction at low speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

if TYPE_CHECKING:
    from flexros.robot.symbolic.kinematics import Value

SLOWEST = 1e-12
"""Smallest Stribeck velocity that is distinguished from zero [rad/s or m/s]."""
GAUSSIAN = 2.0
"""Exponent of a hump of Gaussian shape, that of the thesis [1]."""


def hump(speed: ca.SX, extra: Value, velocity: Value, exponent: Value) -> ca.SX:
    """Evaluate the extra friction at low speed, extra exp(-|v / velocity|^exponent) (Moberg 2007, eq. 3.15)."""
    relative = speed / ca.fmax(velocity, SLOWEST)
    if not isinstance(exponent, ca.SX) and exponent == GAUSSIAN:
        return extra * ca.exp(-(relative**2))
    power = ca.exp(exponent * ca.log(ca.fabs(relative)))  # several times as fast as the power, and zero at standstill
    return extra * ca.exp(-power)
