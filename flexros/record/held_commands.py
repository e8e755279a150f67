"""What all readers of logs have in common: which command was held at each measurement, and what even sampling means.

Frequency responses take sampling instants from a plan and allow stamps beside them (`frf.record_timing`); the rigid
regression and the prediction of one axis know of no plan, and ask for intervals that are even by `EVEN`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

EVEN = 1e-3
"""Deviation of an interval, in intervals, that counts as even sampling (chosen)."""

LONGEST_HELD = 5
"""Most samples in a row without a command within a record: a longer hole is a loss of the recorder, not a command that
the robot held, and spoils every line (chosen)."""


@dataclass(frozen=True, eq=False)
class HeldCommands:
    """Which command was held at each measurement: the last one that is not later.

    Attributes:
        place: Row of the command, shape (n,); -1 where none came before.
        first: Row of the first measurement with a command; n where there is none.
    """

    place: IntArray
    first: int

    @classmethod
    def of(cls, commands: IntArray, measurements: IntArray) -> HeldCommands:
        """Compare stamps, or numbers of samples.

        Args:
            commands: Stamps of the commands, increasing, shape (k,).
            measurements: Stamps of the measurements, increasing, in the same unit, shape (n,).
        """
        place = np.searchsorted(commands, measurements, side="right") - 1
        return cls(place, int(np.searchsorted(place, 0)))

    def values(self, commands: FloatArray) -> FloatArray:
        """Return the command at each measurement; before `first` that is the first command, which did not act yet.

        Args:
            commands: Values of the commands, shape (k,) or (k, M).

        Returns:
            Values, shape (n,) or (n, M).
        """
        return np.asarray(commands[np.maximum(self.place, 0)])
