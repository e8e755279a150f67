"""Use of the motor torque limits by the commands of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

AT_LIMIT = 1.0 - 1e-9
"""Share of the limit from which a command counts as limited, chosen: allows for rounding of a saturating controller."""
SAMPLES_AT_LIMIT = ".samples_at_torque_limit"
"""Suffix of the key that counts a motor's samples at its limit."""
BATCH = 1000
"""Commands evaluated together, chosen: one at a time would cost the loop a microsecond per sample."""


class TorqueUse:
    """Counts the samples at the torque limit, for each motor that has one.

    Args:
        names: Names of the motors.
        limits: Largest torque in either direction [Nm or N], shape (M,); infinite where there is none.
    """

    def __init__(self, names: Sequence[str], limits: FloatArray) -> None:
        self._limited = [(number, name) for number, name in enumerate(names) if np.isfinite(limits[number])]
        self._limits = limits
        self._peak = np.zeros(len(names))
        self._at_limit = np.zeros(len(names), dtype=int)
        self._batch: list[FloatArray] = []

    def add(self, command: FloatArray) -> None:
        """Add the command of a sample [Nm or N], shape (M,)."""
        self._batch.append(command)
        if len(self._batch) >= BATCH:
            self._evaluate()

    def figures(self) -> dict[str, float]:
        """Return the largest share of the limit and the number of samples at it, by motor."""
        if self._batch:
            self._evaluate()
        return {f"{name}.largest_share_of_torque_limit": float(self._peak[i]) for i, name in self._limited} | {
            f"{name}{SAMPLES_AT_LIMIT}": int(self._at_limit[i]) for i, name in self._limited
        }

    def _evaluate(self) -> None:
        shares = np.abs(np.array(self._batch)) / self._limits
        self._batch.clear()
        self._peak = np.maximum(self._peak, shares.max(axis=0))
        self._at_limit += (shares >= AT_LIMIT).sum(axis=0)
