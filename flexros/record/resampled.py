"""A record at another sample time: a second log whose rate differs a little, or one of a very fast recorder."""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.local_cubic import local_cubic
from flexros.record.missing_samples import MOST_BRIDGED
from flexros.record.torques.shifted_torque import moved_later

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.record import Record

SAME_RATE = 1e-3
"""Relative difference of sample times up to which two records have the same rate [1] (chosen)."""

MOST_RAISED = 0.2
"""Relative increase of the rate up to which a record is resampled [1] (chosen): beyond it there would be far more
samples than measurements, whose noise is not independent. The mean rate of a recorder with late samples, whose usual
interval is the same, varies from log to log by a tenth."""

FASTEST = 2000.0
"""Highest rate of a real machine's log that is used as it is [Hz] (chosen): above, samples cost time and tell nothing
more about a robot arm."""

USUAL = 1000.0
"""Rate to which a faster one is lowered, by a whole factor [Hz] (chosen)."""


def at_usual_rate(record: Record) -> Record:
    """Lower the rate of a real machine's log above `FASTEST`; return any other as it is.

    Args:
        record: The record.
    """
    rate = 1 / record.sample_time
    if not record.imported or rate <= (1 + SAME_RATE) * FASTEST:
        return record
    return resampled(record, round(rate / USUAL) * record.sample_time, "which suffices for a robot arm")


def with_fewer_samples(record: Record, plenty: int, lowest_rate: float, reason: str) -> Record:
    """Lower the rate of a record with more samples than are needed by a whole factor.

    Args:
        record: The record.
        plenty: Samples of all motors together that are enough.
        lowest_rate: Lowest rate [Hz].
        reason: Why fewer samples are enough, for the warning.
    """
    factor = min(int((1 + SAME_RATE) / (record.sample_time * lowest_rate)), ceil(record.position.size / plenty))
    return record if factor <= 1 else resampled(record, factor * record.sample_time, reason)


def may_be_resampled(record: Record, sample_time: float) -> bool:
    """Whether a record holds enough samples for another sample time.

    Args:
        record: The record.
        sample_time: The other sample time [s].
    """
    return record.sample_time <= (1 + MOST_RAISED) * sample_time


def resampled(record: Record, sample_time: float, reason: str = "the rate of the fitted log") -> Record:
    """Resample a record.

    Positions are interpolated by cubics, in long holes and other signals linearly; torques and commanded positions are
    averaged over each new sample, and noted torques over as long a time around its stamp. A new sample is valid where
    the old ones beside it are, and late where any within it is.

    Args:
        record: The record.
        sample_time: The new sample time [s].
        reason: Why, for the warning.

    Returns:
        The record at that sample time, without periodic parts, whose samples were counted at the old one; the same
        record where the sample times are equal within `SAME_RATE`.
    """
    old = record.sample_time
    if abs(sample_time / old - 1) <= SAME_RATE:
        return record
    n = int(np.floor(record.duration / sample_time + 1e-9)) + 1
    before: FloatArray = np.arange(record.n_samples, dtype=np.float64) * old
    at: FloatArray = np.arange(n, dtype=np.float64) * sample_time
    left = np.clip(np.floor(at / old + 1e-9).astype(np.int64), 0, record.n_samples - 1)
    right = np.minimum(left + (at > before[left] + 1e-9 * old), record.n_samples - 1)

    def linear(values: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(at, before, one) for one in values.T])

    edges, ends = np.append(at, at[-1] + sample_time), np.append(before, before[-1] + old)
    spans = np.diff(np.minimum(edges, ends[-1]))

    def mean(values: FloatArray) -> FloatArray:
        integral = np.vstack([np.zeros((1, values.shape[1])), old * np.cumsum(values, axis=0)])
        sums = np.column_stack([np.interp(edges, ends, column) for column in integral.T])
        return np.asarray(np.diff(sums, axis=0) / spans[:, None])

    text = f"{record.name} has {1 / old:.6g} samples per second; it was resampled to {1 / sample_time:.6g}, {reason}"
    return replace(
        record,
        sample_time=sample_time,
        position=_positions(record, at),
        torque=mean(record.torque),
        command=None if record.command is None else mean(record.command),
        command_rate=None if record.command_rate is None else linear(record.command_rate),
        valid=record.valid[left] & record.valid[right],
        jumps=None
        if record.jumps is None
        else np.diff(np.cumsum(record.jumps)[right], prepend=0.0) * old / sample_time,
        late=None if record.late is None else _any_within(record.late, left, right),
        velocity=None if record.velocity is None else linear(record.velocity),
        noted=None if record.noted is None else mean(moved_later(record.noted, (sample_time / old - 1) / 2)),
        torque_noise=None if record.torque_noise is None else record.torque_noise * np.sqrt(old / sample_time),
        recorder_samples=record.recorder_samples * sample_time / old,
        reference=None if record.reference is None else linear(record.reference),
        parts=(),
        first=round(record.first * old / sample_time),
        warnings=(*record.warnings, text),
    )


def _positions(record: Record, at: FloatArray) -> FloatArray:
    """Interpolate positions at instants of a record [s]: by cubics, linearly in long holes and beyond their ends."""
    time: FloatArray = np.arange(record.n_samples, dtype=np.float64) * record.sample_time
    measured = time[record.valid]
    position = np.column_stack([np.interp(at, time, one) for one in record.position.T])
    hole = np.diff(measured, prepend=-np.inf, append=np.inf)[np.searchsorted(measured, at, side="right")]
    near = hole <= (MOST_BRIDGED + 1 + 1e-9) * record.sample_time
    position[near] = local_cubic(measured, record.position[record.valid], at[near])
    return position


def _any_within(marked: BoolArray, left: IntArray, right: IntArray) -> BoolArray:
    """Return whether any old sample is marked from the one before a new sample to the one before the next."""
    count = np.append(0, np.cumsum(marked))
    end = np.maximum(np.append(left[1:], len(marked)), right + 1)
    return np.asarray(count[end] > count[left])
