"""Wall-clock schedule of a real-time run and the statistics of how well it was kept, free of ROS and of clocks."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Protocol

from flexros_nodes.protocol.real_time.period_histogram import PeriodHistogram

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
        period_p50_us: Median of the period, to 1/500 of the sample time [us].
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

    def answered(self) -> bool:
        """Look whether what the next cycle needs has come."""

    def cycle(self) -> None:
        """Do the cycle that is due."""


class CycleCounts:
    """Periods and lateness of cycles, in bounded memory.

    Args:
        sample_time: T [s].
    """

    def __init__(self, sample_time: float) -> None:
        self._sample_time = sample_time
        self._periods = PeriodHistogram(sample_time)
        self._lateness = PeriodHistogram(sample_time)
        self._late = 0
        self._duration = 0.0

    def add(self, period: float | None, lateness: float) -> None:
        """Note a cycle.

        Args:
            period: Time since the cycle before [s], None for the first of all.
            lateness: Start after due [s].
        """
        if period is not None:
            self._periods.add(period)
            self._duration += period
        self._lateness.add(lateness)
        self._late += lateness > LATE * self._sample_time

    def merged(self, other: CycleCounts) -> CycleCounts:
        """Give the counts of both together."""
        both = CycleCounts(self._sample_time)
        both._periods = self._periods.merged(other._periods)
        both._lateness = self._lateness.merged(other._lateness)
        both._late = self._late + other._late
        both._duration = self._duration + other._duration
        return both

    def statistics(self) -> PeriodStatistics | None:
        """Sum up; None without a period."""
        n, periods = self._lateness.count, self._periods
        if periods.count == 0:
            return None
        return PeriodStatistics(
            cycles=n,
            rate_hz=periods.count / self._duration,
            period_p50_us=1e6 * periods.percentile(50.0),
            period_p99_us=1e6 * periods.percentile(99.0),
            period_max_us=1e6 * periods.longest,
            lateness_p99_us=1e6 * self._lateness.percentile(99.0),
            lateness_max_us=1e6 * self._lateness.longest,
            late=self._late,
            late_percent=100.0 * self._late / n,
        )


class Schedule:
    """Due times k T after a start, and what became of them.

    The clock is given, not fetched: all times are seconds of one monotonic clock.

    Args:
        sample_time: T [s].
    """

    def __init__(self, sample_time: float) -> None:
        self._sample_time = sample_time
        self._before = CycleCounts(sample_time)
        self._recent = CycleCounts(sample_time)
        self._last: float | None = None
        self._n = 0
        self._first_due = 0.0
        self._due = 0.0

    @property
    def due(self) -> float:
        """When the next cycle shall start [s]."""
        return self._due

    def begin(self, first_due: float) -> None:
        """Set the time of the next cycle [s], from which the others follow; what lay before it is no period."""
        self._first_due = self._due = first_due
        self._last, self._n = None, 0

    def started(self, now: float) -> None:
        """Note that the cycle that was due starts now [s].

        Args:
            now: Time at which it starts [s].
        """
        planned = self._first_due + self._n * self._sample_time
        self._recent.add(None if self._last is None else now - self._last, now - planned)
        self._last = now
        self._n += 1
        self._due = max(planned + self._sample_time, now + CATCH_UP * self._sample_time)

    def statistics(self) -> PeriodStatistics | None:
        """Sum up all cycles so far; None before the second."""
        return self._before.merged(self._recent).statistics()

    def recent_statistics(self) -> PeriodStatistics | None:
        """Sum up the cycles since this was asked for the last time; None where there is no period."""
        recent = self._recent
        self._before = self._before.merged(recent)
        self._recent = CycleCounts(self._sample_time)
        return recent.statistics()
