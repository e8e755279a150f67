"""Largest factor on an excitation that keeps a quantity within its limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Swing:
    """A quantity of all motors in one experiment: an offset, and a part that is proportional to the amplitude.

    Attributes:
        name: Name of the quantity.
        offset_low: Lowest value without excitation, shape (M,) or over time (n, M).
        offset_high: Highest value without excitation, same shape.
        swing: Part due to the excitation, shape (n, M).
        low: Lowest value allowed, shape (M,).
        high: Highest value allowed, shape (M,).
    """

    name: str
    offset_low: FloatArray
    offset_high: FloatArray
    swing: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Margin:
    """The smallest margin of one or more swings.

    Attributes:
        factor: By what the excitation may be multiplied; 0 where the offset alone is too much.
        name: Which quantity.
        motor: Number of the motor.
        reached: Largest size reached in the direction of the limit, in the unit of the quantity.
        allowed: The limit in that direction.
        offset: Value without excitation there.
    """

    factor: float
    name: str
    motor: int
    reached: float
    allowed: float
    offset: float


def smallest_margin(swings: Sequence[Swing]) -> Margin:
    """Find the quantity, motor and direction that allow the least.

    Args:
        swings: At least one.

    Returns:
        The smallest margin.
    """
    margins = [margin for swing in swings for margin in (_upwards(swing), _upwards(_mirrored(swing), -1.0))]
    return min(margins, key=lambda margin: margin.factor)


def _upwards(swing: Swing, sign: float = 1.0) -> Margin:
    """Find the tightest motor against the upper limit; signs are turned back for a mirrored quantity."""
    room = np.broadcast_to(swing.high - swing.offset_high, swing.swing.shape)
    rising = swing.swing > 0.0
    factors = np.full(swing.swing.shape, np.inf)
    np.divide(np.maximum(room, 0.0), swing.swing, out=factors, where=rising)
    factors[room < 0.0] = 0.0
    at, motor = np.unravel_index(int(np.argmin(factors)), factors.shape)
    offset = float(np.broadcast_to(swing.offset_high, factors.shape)[at, motor])
    return Margin(
        factor=float(factors[at, motor]),
        name=swing.name,
        motor=int(motor),
        reached=sign * (offset + max(float(swing.swing[at, motor]), 0.0)),
        allowed=sign * float(swing.high[motor]),
        offset=sign * offset,
    )


def _mirrored(swing: Swing) -> Swing:
    return Swing(swing.name, -swing.offset_high, -swing.offset_low, -swing.swing, -swing.high, -swing.low)
