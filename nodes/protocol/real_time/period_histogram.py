"""Percentiles of times in bounded memory and constant time."""

from __future__ import annotations

import math
from array import array

import numpy as np

BINS_PER_PERIOD = 500
"""Bins within one nominal period, chosen: 1 us at 2 kHz."""

PERIODS = 8
"""Nominal periods covered by these bins, chosen."""

GROWTH = 1.02
"""Ratio of the ends of a bin for longer times, chosen: their percentiles are right to 2 %."""

LONG_BINS = 600
"""Bins for longer times, chosen: up to ten minutes at 2 kHz; of even longer ones only number and maximum are kept."""

_LOG_OF_GROWTH = math.log(GROWTH)


class PeriodHistogram:
    """Counts times in equal bins, and longer ones in bins that grow with the time.

    Args:
        period: Nominal period, which sets the width of a bin [s].

    Attributes:
        count: Number of times.
        longest: Largest time [s], minus infinity before the first.
    """

    def __init__(self, period: float) -> None:
        self.count = 0
        self.longest = -float("inf")
        self._per_second = BINS_PER_PERIOD / period
        self._equal = BINS_PER_PERIOD * PERIODS
        self._last = self._equal + LONG_BINS
        self._bins = array("q", bytes(8 * (self._last + 1)))

    def add(self, time: float) -> None:
        """Count a time [s]; a negative one counts as zero."""
        self.count += 1
        if time > self.longest:
            self.longest = time
        i = int(time * self._per_second + 0.5)
        if i >= self._equal:
            i = self._equal + int(math.log(i / self._equal) / _LOG_OF_GROWTH)
        self._bins[min(max(i, 0), self._last)] += 1

    def merged(self, other: PeriodHistogram) -> PeriodHistogram:
        """Return the sum of both histograms; `other` must have the same nominal period."""
        both = PeriodHistogram(BINS_PER_PERIOD / self._per_second)
        both.count = self.count + other.count
        both.longest = max(self.longest, other.longest)
        np.frombuffer(both._bins, np.int64)[:] = np.add(self._bins, other._bins)
        return both

    def percentile(self, share: float) -> float:
        """Return the percentile of a share from 0 to 100 [%], to the width of a bin [s]; beyond them the maximum."""
        i = int(np.searchsorted(np.cumsum(self._bins), share / 100.0 * self.count))
        if i >= self._last:
            return self.longest
        if i >= self._equal:
            i = round(self._equal * GROWTH ** (i - self._equal + 0.5))
        return min(i / self._per_second, self.longest)
