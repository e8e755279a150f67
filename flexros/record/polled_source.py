"""Instants of a source that a recorder polled: values that it took again or missed, found by the motion.

A recorder that reads the latest values of a controller with a period of its own gets some of them again and misses
others. Its stamps are those of the reading. The positions tell how far the motion went from one value to the next, a
whole number of periods of the controller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import binary_dilation

from flexros.logs.time_series import JointSeries
from flexros.record.missing_samples import PAUSE

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.logs.time_series import Log

NEAR = 0.15
"""Largest distance of an interval from a whole number of periods to count as one [1] (chosen)."""
FAR = 0.25
"""Distance from which an interval is off [1] (chosen): stamps with a jitter of 3 % of a period came to 0.19."""
WHOLE = 0.95
"""Share of intervals near a whole number of periods from which a source was polled [1] (chosen)."""
LEAST_SHARE = 0.005
"""Share of intervals other than one period from which the stamps are corrected [1] (chosen)."""
FAST = 0.5
"""Share of the intervals, the fastest ones, that show whether a source was polled [1] (chosen)."""
CLEAR = 0.05
"""Speed over that of the fastest intervals from which the motion tells the periods of an interval [1] (chosen)."""
LONGEST = 4
"""Periods up to which values that were missed are interpolated [1] (chosen)."""
SPAN = 8
"""Intervals to each side over which speeds are taken [1] (chosen)."""
ROUNDED = 1e-3
"""Share of a period that stamps may be early by as they are rounded [1] (chosen)."""
FEWEST = 200
"""Fewest intervals that show it [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class PolledSource:
    """Periods of a source from value to value of a log.

    Attributes:
        period: Time between two values of the source [s].
        steps: Periods from each value of the log to the next one; 0 where it was taken again, shape (n - 1,).
    """

    period: float
    steps: IntArray

    @property
    def repeated(self) -> float:
        """Share of values that were taken again [1]."""
        return float(np.mean(self.steps == 0))

    @property
    def missed(self) -> float:
        """Share of values of the source that the log lacks [1]."""
        return float(np.maximum(self.steps - 1, 0).sum() / max(int(self.steps.sum()), 1))

    def evened(self, series: JointSeries) -> JointSeries:
        """Put a series of the same messages on the periods of the source; short holes are interpolated linearly.

        Torques are the mean of those taken from one value to the next: a recorder may read them more often.

        Args:
            series: The series, n messages.
        """
        kept = np.concatenate([[True], self.steps > 0])
        number = np.concatenate([[0], np.cumsum(self.steps)])[kept]
        slots = np.arange(number[-1] + 1)
        after = np.searchsorted(number, slots)
        hole = number[after] - number[np.maximum(after - 1, 0)]
        slots = slots[(number[after] == slots) | (hole <= LONGEST)]

        def filled(values: FloatArray | None) -> FloatArray | None:
            if values is None:
                return None
            return np.column_stack([np.interp(slots, number, column) for column in values[kept].T])

        stamp = series.stamp[0] + np.rint(slots * self.period * 1e9).astype(np.int64)
        return replace(
            series,
            stamp=stamp,
            position=filled(series.position),
            velocity=filled(series.velocity),
            effort=filled(_means(series.effort, kept)),
            received=None,
        )


def polled_source(stamp: IntArray, position: FloatArray) -> PolledSource | None:
    """Recognize a polled source by its positions, held ones also by their stamps.

    Args:
        stamp: Stamps of the messages [ns], shape (n,).
        position: Positions [rad or m], shape (n, M).

    Returns:
        The source; None where the intervals are no whole numbers of a period, all are one, or too little moves.
    """
    time = (stamp - stamp[0]) * 1e-9
    if not np.all(np.isfinite(position)):
        return None
    new = np.concatenate([[True], np.any(np.diff(position, axis=0) != 0, axis=1)])
    if np.sum(new) < 2 * SPAN + FEWEST:
        return None
    elapsed, speed = _elapsed(time[new], position[new])
    between = np.diff(time[new])
    pause = between > PAUSE * float(np.median(between))
    whole_speed = ~binary_dilation(pause, iterations=SPAN) if pause.any() else ~pause
    fast = (speed > max(float(np.quantile(speed, 1 - FAST)), 1e-150)) & whole_speed
    usual = elapsed[fast & (elapsed > 0)]
    if len(usual) < FEWEST:
        return None
    if np.mean(_one_step(np.diff(position[new], axis=0))[fast]) >= WHOLE:
        return None  # a coarse encoder holds each value as long as its step takes
    held_for = _held_for(time, between[fast])
    period = float(np.median(usual)) if held_for is None else held_for
    shown = elapsed[fast] / period
    whole = np.rint(shown)
    if held_for is None and np.mean(np.abs(shown - whole) < NEAR) < WHOLE:
        return None
    follows = np.minimum(np.cumsum(new)[1:] - 1 - new[1:], len(between) - 1)  # around each interval
    by_stamps = between[fast] * (whole.sum() / between[fast].sum())  # speeds are means over a curved motion
    off, off_by_stamps = (np.abs(shown - one) >= FAR for one in (whole, by_stamps))
    clear = (speed > CLEAR * float(np.quantile(speed, 0.99))) & whole_speed
    same_by_stamps = held_for is not None or np.mean(off_by_stamps) < np.mean(off) + LEAST_SHARE
    if same_by_stamps:
        elapsed, clear = between, between < LONGEST * period
    held = np.mean(~new[1:][fast[follows]])
    if held < LEAST_SHARE and (same_by_stamps or np.mean(whole != 1) < LEAST_SHARE):
        return None
    periods = np.rint(elapsed / period)
    exact = float(between[clear].sum() / max(periods[clear].sum(), 1.0))
    period = exact if abs(exact / period - 1) < NEAR else period
    if held_for is not None:
        clear = np.zeros_like(clear)  # equal values, as at a turn of the motion, are values of the source too
    by_motion = np.where(new[1:], periods[follows], 0.0)
    return PolledSource(period, _steps(time, by_motion, clear[follows], new[1:], period))


def _one_step(change: FloatArray) -> BoolArray:
    """Whether no motor moves by more than the smallest change that it ever makes, shape (k,).

    Args:
        change: Change of positions from each value to the next other one [rad or m], shape (k, M).
    """
    size = np.abs(change)
    least = np.min(size, axis=0, where=size > 0, initial=np.inf)
    return np.asarray(np.all(size < 1.5 * least, axis=1))


def _held_for(time: FloatArray, between: FloatArray) -> float | None:
    """Return the time for which values are held [s], where the stamps alone tell it; it needs no slow motion.

    Args:
        time: Time of each row [s], shape (n,).
        between: Time from each value to the next other one [s], shape (k,).
    """
    row, period = float(np.median(np.diff(time))), float(np.median(between))
    whole = np.abs(between - period * np.rint(between / period)) < 0.5 * row  # to the row
    return period if period > 1.5 * row and np.mean(whole) >= WHOLE else None


def recovered(log: Log, warnings: list[str]) -> Log:
    """Put the joint states of a polled source on its periods, and commands that were taken together with them.

    Args:
        log: The log.
        warnings: Receives what was repaired.

    Returns:
        The log, the same one where nothing was to be repaired.
    """
    states, commands = log.joint_states, log.joint_commands
    if states.position is None or (commands is not None and not np.array_equal(commands.stamp, states.stamp)):
        return log
    known = np.all(np.isfinite(states.position), axis=1)  # the others are missed values
    states, commands = _rows(states, known), None if commands is None else _rows(commands, known)
    assert states.position is not None
    source = polled_source(states.stamp, states.position)
    if source is None:
        return log
    warnings.append(
        f"the recorder polled joint_states: {100 * source.repeated:.2g} % of the values repeat the one before, and "
        f"{100 * source.missed:.2g} % of those of the source were missed; by the motion they are "
        f"{1e3 * source.period:.4g} ms apart, and the stamps were corrected"
    )
    return replace(
        log,
        joint_states=source.evened(states),
        joint_commands=None if commands is None else source.evened(commands),
    )


def _means(values: FloatArray | None, kept: BoolArray) -> FloatArray | None:
    """Return the mean from each row that is kept to the next one, at every row, shape (n, M)."""
    if values is None:
        return None
    group = np.cumsum(kept) - 1
    first = values[kept]
    beyond = np.add.reduceat(values - first[group], np.flatnonzero(kept), axis=0)  # exact where all are alike
    return np.asarray((first + beyond / np.bincount(group)[:, None])[group])


def _rows(series: JointSeries, rows: BoolArray) -> JointSeries:
    """Take some messages of a series, without their times of receipt."""
    parts = (series.position, series.velocity, series.effort)
    position, velocity, effort = (None if values is None else values[rows] for values in parts)
    return JointSeries(series.stamp[rows], series.names, position, velocity, effort)


def _elapsed(time: FloatArray, position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the time from message to message by the motion [s], and the speed of all motors, each shape (n - 1,)."""
    n = len(time)
    before, behind = np.maximum(np.arange(n) - SPAN, 0), np.minimum(np.arange(n) + SPAN, n - 1)
    speed = (position[behind] - position[before]) / np.maximum(time[behind] - time[before], 1e-12)[:, None]
    between = 0.5 * (speed[1:] + speed[:-1])
    square = np.sum(between**2, axis=1)
    elapsed = np.sum(np.diff(position, axis=0) * between, axis=1) / np.maximum(square, 1e-300)
    return elapsed, np.sqrt(square)


def _steps(time: FloatArray, shown: FloatArray, clear: BoolArray, new: BoolArray, period: float) -> IntArray:
    """Count the periods of every interval: by the motion where it is clear, else so that they keep up with stamps.

    A value that is the one before is taken for the next one of the source a whole period later, not half of one.

    Args:
        time: Time of each value [s], shape (n,).
        shown: Periods of every interval by the motion, shape (n - 1,).
        clear: Where the motion tells them, shape (n - 1,).
        new: Which intervals end with another value, shape (n - 1,).
        period: The period [s].
    """
    steps = np.zeros(len(shown), dtype=np.int64)
    reached = 0
    for index in range(len(steps)):
        behind = (time[index + 1] - time[0]) / period - reached
        kept_up = np.rint(behind) if new[index] else np.floor(behind + ROUNDED)
        steps[index] = max(int(shown[index] if clear[index] else kept_up), 0)
        reached += int(steps[index])
    return steps
