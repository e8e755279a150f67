"""Wall-clock schedule of a real-time run, and statistics of its periods and lateness; reads no clock."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Protocol

from flexros_nodes.protocol.real_time.period_histogram import PeriodHistogram

LATE = 0.1
"""Share of the sample time after which a cycle that starts behind its due time counts as late."""

CATCH_UP = 0.5
"""Shortest period while a delay is caught up, in sample times: the partner needs time to answer."""


@dataclass(frozen=True)
class PeriodStatistics:
    """Periods and lateness of a real-time run.

    Attributes:
        cycles: Number of cycles.
        rate_hz: Mean rate [Hz].
        period_p50_us: Median of the period, to 1/500 of the sample time [us].
        period_p99_us: 99th percentile of the period [us].
        period_max_us: Longest period [us].
        lateness_p99_us: 99th percentile of the start behind the due time [us].
        lateness_max_us: Largest start behind the due time [us].
        late: Cycles that started more than a tenth of the sample time behind their due time.
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
        """Return the figures by name."""
        return asdict(self)


class Paced(Protocol):
    """Work of a node that the spinning loop starts at the times of a schedule.

    Attributes:
        schedule: Due times, None while there is nothing to pace.
        prioritised: Whether the pacing thread has real-time priority; set by the spinning loop.
    """

    schedule: Schedule | None
    prioritised: bool

    def answered(self) -> bool:
        """Return whether the input of the next cycle has arrived."""

    def cycle(self) -> None:
        """Execute the cycle that is due."""


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
        """Count a cycle.

        Args:
            period: Time since the previous cycle [s], None for the first.
            lateness: Start minus due time [s].
        """
        if period is not None:
            self._periods.add(period)
            self._duration += period
        self._lateness.add(lateness)
        self._late += lateness > LATE * self._sample_time

    def merged(self, other: CycleCounts) -> CycleCounts:
        """Return the sum of both counts."""
        both = CycleCounts(self._sample_time)
        both._periods = self._periods.merged(other._periods)
        both._lateness = self._lateness.merged(other._lateness)
        both._late = self._late + other._late
        both._duration = self._duration + other._duration
        return both

    def statistics(self) -> PeriodStatistics | None:
        """Return the statistics; None without a period."""
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
    """Due times k T after a start, and the statistics of the actual ones.

    All times are arguments, in seconds of one monotonic clock.

    Args:
        sample_time: T [s].
    """

    def __init__(self, sample_time: float) -> None:
        self._sample_time = sample_time
        self._earlier = CycleCounts(sample_time)
        self._recent = CycleCounts(sample_time)
        self._last: float | None = None
        self._n = 0
        self._first_due = 0.0
        self._due = 0.0

    @property
    def due(self) -> float:
        """Due time of the next cycle [s]."""
        return self._due

    def begin(self, first_due: float) -> None:
        """Set the time of the next cycle [s], from which the others follow; the time before it counts as no period."""
        self._first_due = self._due = first_due
        self._last, self._n = None, 0

    def started(self, now: float) -> None:
        """Register that the due cycle starts now [s]."""
        planned = self._first_due + self._n * self._sample_time
        self._recent.add(None if self._last is None else now - self._last, now - planned)
        self._last = now
        self._n += 1
        self._due = max(planned + self._sample_time, now + CATCH_UP * self._sample_time)

    def statistics(self) -> PeriodStatistics | None:
        """Return the statistics of all cycles so far; None before the second."""
        return self._earlier.merged(self._recent).statistics()

    def recent_statistics(self) -> PeriodStatistics | None:
        """Return the statistics of the cycles since the last call; None where there is no period."""
        recent = self._recent
        self._earlier = self._earlier.merged(recent)
        self._recent = CycleCounts(self._sample_time)
        return recent.statistics()
