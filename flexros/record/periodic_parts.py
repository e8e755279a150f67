"""Parts of a log with periodic excitation: whole periods of a multisine in steady state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory.vibration import Vibration

if TYPE_CHECKING:
    from flexros.arrays import IntArray
    from flexros.trajectory import Trajectory

LEAST_LINES = 10
"""Fewest lines of a multisine (chosen)."""


@dataclass(frozen=True, eq=False)
class PeriodicPart:
    """Whole periods of a multisine in steady state.

    Attributes:
        first: First sample of the first period.
        period: Samples of a period.
        n_periods: Number of periods, two or more.
        lines: Excited lines, multiples of one over the period, increasing, shape (F,).
    """

    first: int
    period: int
    n_periods: int
    lines: IntArray

    @property
    def end(self) -> int:
        """Sample after the last period."""
        return self.first + self.n_periods * self.period

    def within(self, begin: int, end: int) -> PeriodicPart | None:
        """Return the whole periods between two samples; None for fewer than two.

        Args:
            begin: First sample, sample 0 of the result.
            end: Sample after the last one.
        """
        skipped = max(0, -((self.first - begin) // self.period))
        n_periods = min(self.n_periods, (end - self.first) // self.period) - skipped
        first = self.first + skipped * self.period - begin
        return PeriodicPart(first, self.period, n_periods, self.lines) if n_periods >= 2 else None


def periodic_parts(trajectory: Trajectory, sample_time: float) -> tuple[PeriodicPart, ...]:
    """Find the multisines of a motion.

    Args:
        trajectory: The reference motion, e.g. of a diagnosis experiment.
        sample_time: Time between two samples [s].

    Returns:
        Parts between the fades, in samples from the beginning of the motion.
    """
    parts = []
    begin = 0.0
    for move in trajectory.moves:
        path = move.path
        if isinstance(path, Vibration) and len(path.frequency) >= LEAST_LINES:
            period = round(1.0 / path.frequency[0] / sample_time)
            lines = np.round(path.frequency * period * sample_time).astype(np.int64)
            # the steady part begins after the fade-in, and its last period ends before the fade-out
            n_periods = int((path.duration - 2 * path.fade) / (period * sample_time) + 1e-6)
            first = round((begin + path.fade) / sample_time)
            if n_periods >= 2:
                parts.append(PeriodicPart(first, period, n_periods, lines))
        begin += move.law.duration
    return tuple(parts)
