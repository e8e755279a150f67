"""A torque of one motor over its own position, as columns of a regression: of a counterbalance, or of unknown law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.counterbalance import Counterbalance
from flexros.effects.kinds.curve import SMALLEST
from flexros.effects.torque_curve import TorqueCurve

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record


@dataclass(frozen=True)
class PositionTorque:
    """A torque of a motor over its own position.

    Attributes:
        motor: Index of the motor.
        span: Lowest and highest position of a curve without a law [rad or m]; None for a counterbalance.
        sizes: Sizes that a regression found, in the order of the effect's [Nm or N]; empty before.
    """

    motor: int
    span: tuple[float, float] | None = None
    sizes: tuple[float, ...] = ()

    @property
    def effect(self) -> type[Counterbalance | TorqueCurve]:
        """The effect that it is."""
        return Counterbalance if self.span is None else TorqueCurve

    @property
    def n_sizes(self) -> int:
        """Number of its sizes."""
        return len(self.effect.ranges)

    @property
    def amplitude(self) -> float:
        """Half of the difference of its largest and smallest value [Nm or N]."""
        return float(np.linalg.norm(self.sizes) if self.span is None else np.ptp(self.sizes) / 2)

    def columns(self, position: FloatArray) -> FloatArray:
        """Return the torque per size [1], shape (n, n_sizes).

        Args:
            position: Positions of the motor [rad or m], shape (n,).
        """
        if self.span is None:
            return np.stack([np.cos(position), np.sin(position)], axis=-1)
        low, high = self.span
        knots = np.linspace(low, max(high, low + SMALLEST), self.n_sizes)
        return np.stack([np.interp(position, knots, one) for one in np.eye(self.n_sizes)], axis=-1)


def curve_of(record: Record, motor: int) -> PositionTorque:
    """Return a curve without a law over the positions that a motor has in a log.

    Args:
        record: The log.
        motor: Index of the motor.
    """
    position = record.position[record.valid, motor]
    return PositionTorque(motor, (float(position.min()), float(position.max())))
