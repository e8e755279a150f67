"""How near the commands of a run come to the torque limits of the motors; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

AT_LIMIT = 1.0 - 1e-9
"""Share of the limit from which on a command counts as limited, chosen: rounding of a controller that cuts off."""
SAMPLES_AT_LIMIT = ".samples_at_torque_limit"
"""End of the key of a motor's samples at its limit."""
TOGETHER = 1000
"""Commands that are counted together, chosen: one by one it would cost the loop a microsecond for each sample."""


class TorqueUse:
    """Counts the samples at the torque limit, for each motor that has one.

    Args:
        names: Names of the motors.
        limits: Largest torque either way [Nm or N], shape (M,); infinite where there is none.
    """

    def __init__(self, names: Sequence[str], limits: FloatArray) -> None:
        self._limited = [(number, name) for number, name in enumerate(names) if np.isfinite(limits[number])]
        self._limits = limits
        self._peak = np.zeros(len(names))
        self._at_limit = np.zeros(len(names), dtype=int)
        self._waiting: list[FloatArray] = []

    def take(self, command: FloatArray) -> None:
        """Count the command of a sample [Nm or N], shape (M,)."""
        self._waiting.append(command)
        if len(self._waiting) >= TOGETHER:
            self._count()

    def figures(self) -> dict[str, float]:
        """Give the largest share of the limit and the number of samples at it, by motor."""
        if self._waiting:
            self._count()
        return {f"{name}.largest_share_of_torque_limit": float(self._peak[i]) for i, name in self._limited} | {
            f"{name}{SAMPLES_AT_LIMIT}": int(self._at_limit[i]) for i, name in self._limited
        }

    def _count(self) -> None:
        shares = np.abs(np.array(self._waiting)) / self._limits
        self._waiting.clear()
        self._peak = np.maximum(self._peak, shares.max(axis=0))
        self._at_limit += (shares >= AT_LIMIT).sum(axis=0)
