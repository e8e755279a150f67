"""Unit of positions and velocities: by each other, by the range of the joints and by the torque of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.logs.foreign.quantities import UNITS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

DEGREES = float(np.degrees(1.0))
"""Degrees in a radian."""
TURNS_PER_MINUTE = {"rad": 2 * np.pi / 60, "deg": 6.0}
"""A turn per minute, in the unit of the positions per second."""
NEAR = 1.25
"""Factor within which a velocity is the derivative of a position (chosen)."""
ALIKE = 0.8
"""Correlation of a velocity with the derivative of the position from which they are compared (chosen)."""
TURNS = 4 * np.pi
"""Largest position that a joint reaches in radians, two turns [rad] (chosen): beyond it positions are degrees."""


@dataclass(frozen=True)
class VelocityMatch:
    """Velocities compared with the derivatives of the positions.

    Attributes:
        factor: Derivative of the position over the velocity [1]; NaN where they are not alike.
        sign: -1 where they are opposite.
    """

    factor: float
    sign: int


def compare_velocity(time: FloatArray, position: FloatArray, velocity: FloatArray) -> VelocityMatch:
    """Compare a velocity with the derivative of a position.

    Args:
        time: Times [s], shape (n,).
        position: Positions in the unit of the file, shape (n,).
        velocity: Velocities in the unit of the file, shape (n,).
    """
    derivative = np.gradient(position, time)
    if not (np.std(derivative) > 0 and np.std(velocity) > 0):
        return VelocityMatch(float("nan"), 1)
    correlation = float(np.corrcoef(derivative, velocity)[0, 1])
    if abs(correlation) < ALIKE:
        return VelocityMatch(float("nan"), 1)
    factor = float(derivative @ velocity / (velocity @ velocity))
    return VelocityMatch(abs(factor), 1 if factor > 0 else -1)


def in_degrees(positions: Sequence[FloatArray]) -> bool:
    """Whether rotary joints leave two turns, as in degrees.

    Args:
        positions: Positions of every joint in the unit of the file, shape (n,) each.
    """
    return max(float(np.abs(position).max()) for position in positions) > TURNS


def unit_ratio(factors: Sequence[float]) -> float:
    """Return the unit of the velocities over that of the positions per second; NaN where none fits.

    It is 1, 57.3 or 1/57.3, or that of turns per minute.

    Args:
        factors: Derivative of the position over the velocity of every joint [1].
    """
    known = [factor for factor in factors if np.isfinite(factor)]
    if not known:
        return float("nan")
    middle = float(np.median(known))
    ratios = (1.0, DEGREES, 1 / DEGREES, *TURNS_PER_MINUTE.values())
    return next((ratio for ratio in ratios if 1 / NEAR < middle / ratio < NEAR), float("nan"))


def velocity_unit(position: str, ratio: float = float("nan")) -> str:
    """Return the unit of velocities beside positions in a unit.

    Args:
        position: Unit of the positions.
        ratio: Unit of the velocities over that of the positions per second [1]; NaN where it is not known.
    """
    own = UNITS[position]
    size = own.factor * (ratio if np.isfinite(ratio) else 1.0)
    units = {name: unit for name, unit in UNITS.items() if (unit.kind, unit.rotary) == ("velocity", own.rotary)}
    return min(units, key=lambda name: abs(float(np.log(units[name].factor / size))))
