"""Commands of a table whose names say no quantity, as cmd_elbow: positions or torques, by their values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

NEAR = 0.5
"""Distance from the positions, over their size, up to which commands are positions [1] (chosen): 0.02 to 0.16 in logs
of simulated servos, 0.9 to 30 with torques of the same arms; torques near zero are at 1."""
CLEAR = (0.3, 0.8)
"""Distances up to which they clearly are positions, and from which they clearly are not [1] (chosen)."""


@dataclass(frozen=True)
class UnnamedCommands:
    """What commands whose names say no quantity are.

    Attributes:
        distance: Rms of commands minus measured positions of all joints over the rms of these positions [1].
    """

    distance: float

    @classmethod
    def of(cls, commands: Sequence[FloatArray], positions: Sequence[FloatArray]) -> UnnamedCommands:
        """Compare commands with measured positions.

        Args:
            commands: Commands of every joint in the unit of the file, shape (n,) each.
            positions: Measured positions of these joints in the unit of the file, shape (n,) each.
        """
        measured = np.array(positions)
        rows = np.isfinite(measured) & np.isfinite(commands)
        size = float(np.sum(measured[rows] ** 2))
        distance = float(np.sum((np.array(commands) - measured)[rows] ** 2))
        return cls(float(np.sqrt(distance / max(size, 1e-300))))

    @property
    def quantity(self) -> Literal["position", "torque"]:
        """What they are."""
        return "position" if self.distance < NEAR else "torque"

    @property
    def clear(self) -> bool:
        """Whether the distance leaves no doubt."""
        return not CLEAR[0] < self.distance < CLEAR[1]
