"""Wall-clock schedule of a real-time run and the statistics of how well it was kept, free of ROS and of clocks."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Protocol

import numpy as np

LATE = 0.1
"""A cycle is late when it starts more than this share of the sample time after it is due."""

CATCH_UP = 0.5
"""Least distance between two cycles while a delay is caught up, in sample times: the partner needs time to answer."""


@dataclass(frozen=True)
class PeriodStatistics:
    """How well a real-time run kept its schedule.

    Attributes:
        cycles: Number of cycles.
        rate_hz: Mean rate [Hz].
        period_p50_us: Median of the period [us].
        period_p99_us: 99th percentile of the period [us].
        period_max_us: Longest period [us].
        lateness_p99_us: 99th percentile of start after due [us].
        lateness_max_us: Largest start after due [us].
        late: Cycles that started more than a tenth of the sample time after due.
        late_percent: The same as a share of all cycles [%].
    """

    cycles: int
    rate_hz: float
    period_p50_us: float
    period_p99_us: float
    period_max_us: float
    lateness_p99_us: float
    lateness_max_us: float
    late: int
    late_percent: float

    def as_dict(self) -> dict[str, float]:
        """Give the figures by name."""
        return asdict(self)


class Paced(Protocol):
    """A node whose work whoever spins it has to start at the times of a schedule.

    Attributes:
        schedule: Due times, None while there is nothing to pace.
        prioritised: Whether the thread that paces has real-time priority; set by whoever spins.
    """

    schedule: Schedule | None
    prioritised: bool

    @property
    def answered(self) -> bool:
        """Whether what the next cycle needs is there."""

    def cycle(self) -> None:
        """Do the cycle that is due."""


class Schedule:
    """Due times k T after a start, and what became of them.

    The clock is given, not fetched: all times are seconds of one monotonic clock.

    Args:
        sample_time: T [s].
        n_cycles: Number of cycles for which space is kept.
    """

    def __init__(self, sample_time: float, n_cycles: int) -> None:
        self._sample_time = sample_time
        self._starts = np.empty(max(n_cycles, 1))
        self._n = 0
        self._first_due = 0.0
        self._due = 0.0

    @property
    def due(self) -> float:
        """When the next cycle shall start [s]."""
        return self._due

    def begin(self, first_due: float) -> None:
        """Set the time of cycle 0 [s]."""
        self._first_due = self._due = first_due

    def started(self, now: float) -> None:
        """Note that the cycle that was due starts now [s].

        Args:
            now: Time at which it starts [s].
        """
        if self._n < len(self._starts):
            self._starts[self._n] = now
        self._n += 1
        planned = self._first_due + self._n * self._sample_time
        self._due = max(planned, now + CATCH_UP * self._sample_time)

    def statistics(self) -> PeriodStatistics | None:
        """Sum up all cycles so far; None before the second."""
        n = min(self._n, len(self._starts))
        if n < 2:
            return None
        starts = self._starts[:n]
        periods = np.diff(starts)
        lateness = starts - (self._first_due + np.arange(n) * self._sample_time)
        late = int(np.count_nonzero(lateness > LATE * self._sample_time))
        p50, p99, longest = np.percentile(periods, [50.0, 99.0, 100.0]) * 1e6
        return PeriodStatistics(
            cycles=n,
            rate_hz=float((n - 1) / (starts[-1] - starts[0])),
            period_p50_us=float(p50),
            period_p99_us=float(p99),
            period_max_us=float(longest),
            lateness_p99_us=float(np.percentile(lateness, 99.0) * 1e6),
            lateness_max_us=float(lateness.max() * 1e6),
            late=late,
            late_percent=100.0 * late / n,
        )
