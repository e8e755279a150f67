"""Timing of the control loop: period, gaps, order and matching of stamps; in real time also its pace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.elapsed_time import elapsed_seconds, start_stamp
from flexros.analysis.pace import ArrivalTiming, Pacing, loop_arrivals, plant_pacing, ran_in_real_time

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log, Series

_GAP = 1.5
"""A step of more than this many periods has lost at least one sample."""
_ROUND_OFF = 1
"""Steps of stamps on an exact grid differ by this much from rounding to whole nanoseconds [ns]."""
_AT_ONCE = 100_000
"""Stamps that are compared at once (chosen)."""
_NAMED_GAPS = 20
"""Number of gaps that are listed one by one; all are counted."""


@dataclass(frozen=True)
class Gap:
    """Samples missing between two consecutive stamps.

    Attributes:
        time: Time of the last sample before the gap, from the start of the log [s].
        missing: Number of samples missing in it.
    """

    time: float
    missing: int


@dataclass(frozen=True, eq=False)
class TopicTiming:
    """Timing of one topic.

    Attributes:
        topic: Name of the topic.
        count: Number of messages.
        start: Time of the first stamp, from the start of the log [s].
        period: Median of the steps between stamps [s]; nan with fewer than two different stamps.
        mean_period: Mean of the steps without gaps [s].
        jitter_std: Standard deviation of the steps without gaps [s].
        jitter_p99: 99th percentile of |step - period| over these steps [s].
        jitter_max: Largest |step - period| over these steps [s].
        missed: Number of samples missing in gaps.
        gaps: The first gaps, at most 20.
        duplicates: Number of messages whose stamp occurred before.
        out_of_order: Number of messages whose stamp is older than the previous one.
        exact: Whether the stamps are on an exact grid: no step differs from the period by more than rounding.
        stamps: The different stamps, increasing [ns], shape (n,).
        begin: Stamp of the start of the log [ns].
    """

    topic: str
    count: int
    start: float
    period: float
    mean_period: float
    jitter_std: float
    jitter_p99: float
    jitter_max: float
    missed: int
    gaps: tuple[Gap, ...]
    duplicates: int
    out_of_order: int
    exact: bool
    stamps: IntArray
    begin: int

    @property
    def steps(self) -> FloatArray:
        """Steps between consecutive stamps [s], shape (n - 1,)."""
        return elapsed_seconds(np.diff(self.stamps), 0)

    @property
    def step_time(self) -> FloatArray:
        """Time of the end of each step, from the start of the log [s], shape (n - 1,)."""
        return elapsed_seconds(self.stamps[1:], self.begin)

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers with their units in the keys."""
        return {
            "count": self.count,
            "start_s": self.start,
            "period_s": self.period if np.isfinite(self.period) else None,
            "mean_period_s": self.mean_period if np.isfinite(self.mean_period) else None,
            "jitter_std_s": self.jitter_std,
            "jitter_p99_s": self.jitter_p99,
            "jitter_max_s": self.jitter_max,
            "missed": self.missed,
            "gaps": [{"time_s": gap.time, "missing": gap.missing} for gap in self.gaps],
            "duplicates": self.duplicates,
            "out_of_order": self.out_of_order,
            "exact": self.exact,
        }


@dataclass(frozen=True)
class LoopTiming:
    """Timing of all topics of a log and of the loop they form.

    Attributes:
        topics: Timing of each topic present, joint_states first.
        answered: Share of joint_states with a joint_commands message of the same stamp; 1 in lock-step.
        unanswered: Number of joint_states without one.
        unasked: Number of joint_commands without a joint_states message of the same stamp.
        real_time: Whether the loop ran by the wall clock; False in lock-step or simulated, None where unknown.
        arrivals: Receive times of the messages of the loop, where known.
        pacing: Schedule of the plant; None where it had none or did not report it.
    """

    topics: tuple[TopicTiming, ...]
    answered: float
    unanswered: int
    unasked: int
    real_time: bool | None = None
    arrivals: tuple[ArrivalTiming, ...] = ()
    pacing: Pacing | None = None

    @property
    def exact(self) -> bool:
        """Whether all stamps are on an exact grid and every state has its command: no sample was lost."""
        return all(topic.exact for topic in self.topics) and self.unanswered == 0 and self.unasked == 0

    def topic(self, name: str) -> TopicTiming | None:
        """Return the timing of one topic, or None where the log does not have it."""
        return next((topic for topic in self.topics if topic.topic == name), None)

    def arrival(self, name: str) -> ArrivalTiming | None:
        """Return the receive times of a topic of the loop, or None where they are not known."""
        return next((arrival for arrival in self.arrivals if arrival.topic == name), None)

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers with their units in the keys."""
        return {
            "real_time": self.real_time,
            "exact": self.exact,
            "answered_share": self.answered,
            "states_without_command": self.unanswered,
            "commands_without_state": self.unasked,
            "topics": {topic.topic: topic.as_dict() for topic in self.topics},
            "received": {arrival.topic: arrival.as_dict() for arrival in self.arrivals},
            "pacing": None if self.pacing is None else self.pacing.as_dict(),
        }


def loop_timing(log: Log) -> LoopTiming:
    """Evaluate the stamps of a log, and in real time receive times and the schedule of the plant.

    Args:
        log: The log; missing topics are omitted.
    """
    series: dict[str, Series | None] = {
        "joint_states": log.joint_states,
        "joint_commands": log.joint_commands,
        "joint_reference": log.joint_reference,
        "tool_pose": log.tool_pose,
        "tool_reference": log.tool_reference,
        **log.other_series,
    }
    present = {name: values.stamp for name, values in series.items() if values is not None and len(values.stamp) > 0}
    start = start_stamp(log)
    states = present.get("joint_states", np.empty(0, dtype=np.int64))
    commands = present.get("joint_commands", np.empty(0, dtype=np.int64))
    # A log that ends between a measurement and its command has not lost that command.
    asked = states[: np.searchsorted(states, commands[-1], side="right")] if len(commands) else states
    matched = _common(asked, commands)
    return LoopTiming(
        topics=tuple(topic_timing(name, stamp, start) for name, stamp in present.items()),
        answered=matched / len(asked) if len(asked) else 0.0,
        unanswered=len(asked) - matched,
        unasked=len(commands) - _common(commands, states),
        real_time=ran_in_real_time(log),
        arrivals=loop_arrivals(log),
        pacing=plant_pacing(log.plant_figures),
    )


def _common(stamps: IntArray, others: IntArray) -> int:
    """Count the stamps that others has too; both increase."""
    if not len(others):
        return 0
    return sum(
        int(np.count_nonzero(others[np.minimum(np.searchsorted(others, some), len(others) - 1)] == some))
        for some in np.array_split(stamps, 1 + len(stamps) // _AT_ONCE)
    )


def topic_timing(topic: str, stamp: IntArray, start: int) -> TopicTiming:
    """Evaluate the stamps of one topic.

    Args:
        topic: Name of the topic.
        stamp: Stamps in the order of the log [ns], shape (n,), n >= 1.
        start: Stamp of time 0 [ns].

    Returns:
        Period, jitter, misses, duplicates and order.
    """
    different = stamp if np.all(np.diff(stamp) > 0) else np.unique(stamp)  # that of the log, not a copy
    step = np.diff(different)
    period = float(np.median(step)) if len(step) else float("nan")
    long = step > _GAP * period
    missing = np.rint(step[long] / period) - 1.0
    worst = np.flatnonzero(long)[:_NAMED_GAPS]
    gaps = tuple(Gap(float((different[k] - start) * 1e-9), int(n)) for k, n in zip(worst, missing, strict=False))
    whole = step[~long] if len(missing) else step
    jitter = whole - period
    np.abs(jitter, out=jitter)
    return TopicTiming(
        topic=topic,
        count=len(stamp),
        start=float((int(stamp[0]) - start) * 1e-9),
        period=period * 1e-9,
        mean_period=float(np.mean(whole)) * 1e-9 if len(whole) else float("nan"),
        jitter_std=float(np.std(whole)) * 1e-9 if len(whole) else 0.0,
        jitter_p99=float(np.percentile(jitter, 99.0)) * 1e-9 if len(whole) else 0.0,
        jitter_max=float(np.max(jitter, initial=0.0)) * 1e-9,
        missed=int(np.sum(missing)),
        gaps=gaps,
        duplicates=len(stamp) - len(different),
        out_of_order=int(np.count_nonzero(np.diff(stamp) < 0)),
        exact=not len(missing) and bool(np.all(jitter <= _ROUND_OFF)) and len(stamp) == len(different),
        stamps=different,
        begin=start,
    )
