"""Repeated cycles of a run, where the commanded path repeats itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from flexros.analysis.path_geometry import distances, step_lengths

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

_AT_REST = 1e-7
"""A commanded path that moves less than this [m] per sample is at rest."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """One pass of the commanded path, with the attained one.

    Attributes:
        time: Time of each sample [s], shape (n,).
        commanded: Commanded position [m], shape (n, 3).
        attained: Attained position [m], shape (n, 3).
        commanded_orientation: Commanded orientation, quaternion x y z w, shape (n, 4); None where not commanded.
        attained_orientation: Attained orientation, quaternion x y z w, shape (n, 4); None where not commanded.
    """

    time: FloatArray
    commanded: FloatArray
    attained: FloatArray
    commanded_orientation: FloatArray | None = None
    attained_orientation: FloatArray | None = None

    def arc_length(self) -> FloatArray:
        """Return the commanded distance since the beginning of the cycle [m], shape (n,), never decreasing."""
        return np.concatenate([[0.0], np.cumsum(step_lengths(self.commanded))])

    def part(self, start: int, stop: int) -> Cycle:
        """Return the samples from `start` up to, not including, `stop`."""
        cut = slice(start, stop)
        return Cycle(
            self.time[cut],
            self.commanded[cut],
            self.attained[cut],
            None if self.commanded_orientation is None else self.commanded_orientation[cut],
            None if self.attained_orientation is None else self.attained_orientation[cut],
        )


def split_cycles(run: Cycle) -> tuple[Cycle, ...]:
    """Split a run into the repetitions of its commanded path.

    Rest before the first and after the last move is removed, except one sample of it on either side.

    Args:
        run: The whole run.

    Returns:
        The cycles, at least one; a path that does not repeat, or does not move at all, is one cycle.
    """
    moving = np.flatnonzero(step_lengths(run.commanded) > _AT_REST)
    if len(moving) == 0:
        return (run,)
    first, last = int(moving[0]), int(moving[-1]) + 2
    period = repetition(run.commanded[first:last])
    if period is None:
        return (run.part(first, last),)
    passes = _passes(run.commanded[first:last], period)
    return tuple(run.part(first + k * period, min(first + (k + 1) * period + 1, last)) for k in range(passes))


def repetition(points: FloatArray) -> int | None:
    """Find the number of samples after which a commanded path repeats itself.

    The mean square of p[k + L] - p[k] over all L comes from one correlation; its minima are then checked sample by
    sample.

    Args:
        points: Commanded positions from the first to the last move [m], shape (n, 3).

    Returns:
        The smallest such number of samples, or None where the path is traversed less than twice.
    """
    largest_step = float(np.max(step_lengths(points)))
    for lag in _low_lags(points):
        if _passes(points, int(lag)) < 2:
            continue
        if float(np.max(distances(points[lag:], points[:-lag]))) <= 0.75 * largest_step:
            return int(lag)
    return None


def _passes(points: FloatArray, period: int) -> int:
    """Count the complete passes; the last one is complete without the rest that would follow it."""
    whole, moved = divmod(len(points) - 1, period)
    rest = np.linalg.norm(np.diff(points[moved : period + 1], axis=0), axis=1)
    return whole + int(moved > 0 and bool(np.all(rest <= _AT_REST)))


def _low_lags(points: FloatArray) -> IntArray:
    n = len(points)
    size = next_fast_len(2 * n)
    correlation, square = np.zeros(n), np.zeros(n)
    for column, mean in zip(points.T, points.mean(axis=0), strict=True):
        centred = column - mean
        power = np.abs(rfft(centred, size))
        power *= power
        correlation += irfft(power, size)[:n]
        centred *= centred
        square += centred
    del power, centred  # as long as a column of the log
    total = np.concatenate([[0.0], np.cumsum(square)])
    mean_square = total[:0:-1] + total[n]  # at every lag L: total[n - L] + total[n] - total[L] - 2 correlation[L]
    mean_square -= total[:n]
    correlation *= 2.0
    mean_square -= correlation
    mean_square /= np.arange(n, 0, -1)
    low = np.zeros(n, dtype=bool)
    low[1:-1] = (mean_square[1:-1] <= mean_square[:-2]) & (mean_square[1:-1] <= mean_square[2:])
    low &= mean_square < 1e-3 * total[n] / n
    return np.flatnonzero(low)
