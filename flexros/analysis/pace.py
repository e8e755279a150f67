"""Pace of a loop in real time: receive times of its messages, and the schedule of the plant."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.elapsed_time import elapsed_seconds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log

LOOP_TOPICS = ("joint_states", "joint_commands")
"""Topics that continue sample by sample; references may be sent ahead in bursts."""


@dataclass(frozen=True, eq=False)
class ArrivalTiming:
    """Periods of one topic as its recorder received it.

    Attributes:
        topic: Name of the topic.
        count: Number of messages.
        mean_period: Mean time between two messages [s].
        period_median: Median of it [s].
        period_p99: 99th percentile of it [s].
        period_max: Longest time between two messages [s].
        jitter_std: Standard deviation of it [s].
        steps: Time between two messages, in the order of arrival [s], shape (n - 1,).
        step_time: Time of the end of each step, from the first message on [s], shape (n - 1,).
    """

    topic: str
    count: int
    mean_period: float
    period_median: float
    period_p99: float
    period_max: float
    jitter_std: float
    steps: FloatArray
    step_time: FloatArray

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers with their units in the keys."""
        return {
            "count": self.count,
            "mean_period_s": self.mean_period,
            "period_median_s": self.period_median,
            "period_p99_s": self.period_p99,
            "period_max_s": self.period_max,
            "jitter_std_s": self.jitter_std,
        }


@dataclass(frozen=True)
class Pacing:
    """Wall-clock schedule of the plant, as it reported it; None where it did not.

    Attributes:
        cycles: Number of cycles.
        rate: Mean rate [Hz].
        period_median: Median of the period [s].
        period_p99: 99th percentile of the period [s].
        period_max: Longest period [s].
        lateness_p99: 99th percentile of the delay after the scheduled time [s].
        lateness_max: Largest delay after the scheduled time [s].
        late_share: Share of the cycles that began more than a tenth of the sample time late.
        missed_commands: Samples without a new command, so that the last one was held.
    """

    cycles: int | None = None
    rate: float | None = None
    period_median: float | None = None
    period_p99: float | None = None
    period_max: float | None = None
    lateness_p99: float | None = None
    lateness_max: float | None = None
    late_share: float | None = None
    missed_commands: int | None = None

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers in SI units: seconds, hertz, shares."""
        return asdict(self)


def arrival_timing(topic: str, received: IntArray) -> ArrivalTiming | None:
    """Evaluate the receive times of a topic.

    Args:
        topic: Name of the topic.
        received: Times of receipt, in any order [ns], shape (n,).

    Returns:
        The periods; None for fewer than two messages.
    """
    if len(received) < 2:
        return None
    arrival = np.sort(received)
    steps = elapsed_seconds(np.diff(arrival), 0)
    median, p99, longest = np.percentile(steps, [50.0, 99.0, 100.0])
    return ArrivalTiming(
        topic=topic,
        count=len(arrival),
        mean_period=float(np.mean(steps)),
        period_median=float(median),
        period_p99=float(p99),
        period_max=float(longest),
        jitter_std=float(np.std(steps)),
        steps=steps,
        step_time=elapsed_seconds(arrival[1:], int(arrival[0])),
    )


def loop_arrivals(log: Log) -> tuple[ArrivalTiming, ...]:
    """Evaluate the topics of the loop whose receive times are known."""
    known = [(name, getattr(log, name)) for name in LOOP_TOPICS]
    timings = [
        arrival_timing(name, series.received)
        for name, series in known
        if series is not None and len(series.stamp)
        if series.received is not None
    ]
    return tuple(timing for timing in timings if timing is not None)


def plant_pacing(figures: Mapping[str, float]) -> Pacing | None:
    """Convert the schedule figures of the plant.

    Args:
        figures: Figures of the plant node by key; times in microseconds, shares in percent.

    Returns:
        The same in SI units; None where the plant had no schedule, as in lock-step.
    """
    if not figures.keys() & {"cycles", "missed_commands"}:
        return None

    def scaled(key: str, factor: float = 1e-6) -> float | None:
        return factor * figures[key] if key in figures else None

    def whole(key: str) -> int | None:
        return round(figures[key]) if key in figures else None

    return Pacing(
        cycles=whole("cycles"),
        rate=scaled("rate_hz", 1.0),
        period_median=scaled("period_p50_us"),
        period_p99=scaled("period_p99_us"),
        period_max=scaled("period_max_us"),
        lateness_p99=scaled("lateness_p99_us"),
        lateness_max=scaled("lateness_max_us"),
        late_share=scaled("late_percent", 1e-2),
        missed_commands=whole("missed_commands"),
    )


def ran_in_real_time(log: Log) -> bool | None:
    """Determine whether a loop ran by the wall clock.

    Returns:
        The entry of the provenance. Without it True where the plant had a schedule or messages were received at other
        times than their stamps, False for other runs of a scenario (lock-step or simulated), None where unknown.
    """
    said = log.provenance.get("real_time")
    if isinstance(said, bool):
        return said
    series = (log.joint_states, log.joint_commands, log.joint_reference, log.tool_pose, log.tool_reference)
    if plant_pacing(log.plant_figures) or any(topic is not None and topic.received is not None for topic in series):
        return True
    return False if "scenario" in log.provenance else None
