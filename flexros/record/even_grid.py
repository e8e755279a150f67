"""From stamps to an even grid: sample time, number of every message, what is missing, late or jittering."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray

LOWEST_RATE = 95.0
"""Lowest rate of a log [Hz]: the contract's 100 Hz, less what jitter takes (chosen)."""

HIGHEST_RATE = 2.1e4
"""Highest rate of a log, beyond which its time unit is more likely wrong [Hz] (chosen)."""

MOST_MISSING = 0.5
"""Share of missing samples from which the stamps are no sampling instants (chosen)."""

_FIRST = 32  # messages with which the search for the sample time begins
_GROWTH = 1.5  # factor by which the stretch grows, so that an error of the sample time stays far below a sample
_NEAR = 0.35  # deviation in samples up to which a stamp counts in the fit
_SAME = 0.01  # samples by which a round sample time may be off at the end of the log to be taken


@dataclass(frozen=True, eq=False)
class EvenGrid:
    """Even grid of sampling instants below the messages of a topic.

    Attributes:
        origin: Stamp that counts as time zero [ns].
        start: Instant of slot 0 after `origin` [s].
        sample_time: Time between two slots [s].
        rows: Messages that were taken, one per slot at most, increasing, shape (m,).
        numbers: Their slots, increasing from 0, shape (m,).
        deviation: How much later than the slot each of them is stamped [s], shape (m,).
        warnings: What was noticed, a sentence each.
    """

    origin: int
    start: float
    sample_time: float
    rows: IntArray
    numbers: IntArray
    deviation: FloatArray
    warnings: tuple[str, ...] = ()

    @property
    def n_slots(self) -> int:
        """Number of slots from the first message to the last."""
        return int(self.numbers[-1]) + 1

    @property
    def instants(self) -> FloatArray:
        """Instants of all slots after `origin` [s], shape (n_slots,)."""
        return np.asarray(self.start + self.sample_time * np.arange(self.n_slots), dtype=np.float64)

    @property
    def jitter(self) -> float:
        """Deviation of the stamps, rms [s]."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    def held(self) -> tuple[IntArray, BoolArray]:
        """Give for each slot the place of the message that stands there, and whether it is its own.

        Returns:
            Places among `rows`, shape (n_slots,), and whether the message belongs to the slot, shape (n_slots,).
        """
        slots = np.arange(self.n_slots)
        place = np.searchsorted(self.numbers, slots, side="right") - 1
        return place, self.numbers[place] == slots


def even_grid(stamp: IntArray, nominal: float, topic: str) -> EvenGrid:
    """Find the even grid that lies closest to stamps.

    Args:
        stamp: Stamps [ns], increasing, shape (n,).
        nominal: Sample time that is taken where the stamps agree with it [s].
        topic: Name of the topic with that of the log, for the texts.

    Returns:
        The grid.

    Raises:
        InputError: Too few messages, a rate that is none of a log, or stamps that fit no even grid.
    """
    if len(stamp) < _FIRST:
        raise InputError(f"{topic} has {len(stamp)} messages, needed are at least {_FIRST}; record a longer log")
    time = (stamp - stamp[0]) * 1e-9
    typical = float(np.median(np.diff(time)))
    _check_rate(typical, topic)
    numbers, start, sample_time = _numbers(time, typical)
    warnings: list[str] = []
    missing = 1 - len(np.unique(numbers)) / (numbers[-1] - numbers[0] + 1)
    if missing > MOST_MISSING or len(np.unique(numbers)) < (1 - MOST_MISSING) * len(numbers):
        numbers, start, sample_time = _by_count(time, topic, missing)
        warnings.append(
            f"{topic}: the stamps come in bursts, as those of a recorder do; the samples are taken as even at "
            f"{1 / sample_time:.6g} Hz, so their timing is doubtful"
        )
    sample_time, start = _round(time, numbers, sample_time, start, nominal)
    rows = _one_per_slot(time, numbers, start, sample_time)
    if len(rows) < len(numbers):
        warnings.append(
            f"{topic}: {len(numbers) - len(rows)} messages share a sampling instant with another, late or repeated; "
            "the one nearer to the instant was kept"
        )
    numbers = numbers[rows]
    start, numbers = start + sample_time * int(numbers[0]), numbers - numbers[0]
    deviation = time[rows] - start - sample_time * numbers
    return EvenGrid(int(stamp[0]), start, sample_time, rows, numbers, deviation, tuple(warnings))


def _check_rate(step: float, topic: str) -> None:
    """Refuse rates outside those of a log; a thousandfold one is named."""
    rate = 1 / step
    if LOWEST_RATE <= rate <= HIGHEST_RATE:
        return
    hint = "record at a higher rate" if rate < LOWEST_RATE else "record every sample once"
    for factor, text in ((1e-3, "milliseconds given as microseconds"), (1e-6, "milliseconds given as nanoseconds")):
        if 100 <= rate * factor <= 1e4:
            hint = f"the unit of time looks wrong ({text}, or seconds as milliseconds); correct it"
    for factor, text in ((1e3, "a thousand"), (1e6, "a million")):
        if rate < 1.5 * 10 and 100 <= rate * factor <= 1e4:
            hint = f"the unit of time looks wrong by a factor of {text} (e.g. microseconds given as milliseconds)"
    raise InputError(
        f"{topic} is stamped every {step:.6g} s, which is a rate of {rate:.6g} Hz; allowed are {LOWEST_RATE:g} Hz to "
        f"{HIGHEST_RATE:g} Hz: {hint}"
    )


def _numbers(time: FloatArray, step: float) -> tuple[IntArray, float, float]:
    """Number messages by the nearest slot, in stretches that grow; returns numbers, start and sample time [s]."""
    n, end, start = len(time), _FIRST, float(time[0])
    while True:
        numbers = np.rint((time[:end] - start) / step)
        deviation = time[:end] - start - step * numbers
        near = np.abs(deviation - np.median(deviation)) < _NEAR * step
        if near.sum() >= _FIRST // 4 and np.ptp(numbers[near]) >= _FIRST // 4:
            middle = numbers[near].mean()
            slope = np.polyfit(numbers[near] - middle, deviation[near], 1)
            step, start = step + float(slope[0]), start + float(slope[1] - slope[0] * middle)
        if end == n:
            return np.rint((time - start) / step).astype(np.int64), start, step
        end = min(n, int(np.ceil(_GROWTH * end)))


def _by_count(time: FloatArray, topic: str, missing: float) -> tuple[IntArray, float, float]:
    """Number messages one after the other where the stamps come in bursts around a straight line."""
    numbers = np.arange(len(time))
    slope, start = np.polyfit(numbers, time, 1)
    off = float(np.sqrt(np.mean((time - start - slope * numbers) ** 2)) / slope)
    if not off < 3.0:
        raise InputError(
            f"{topic}: the stamps fit no even sampling, {100 * missing:.0f} % of the samples at the usual interval of "
            f"{1e3 * float(np.median(np.diff(time))):.6g} ms would be missing; check whether units of time are mixed, "
            "or record without losses"
        )
    _check_rate(float(slope), topic)
    return numbers, float(start), float(slope)


def _round(
    time: FloatArray, numbers: IntArray, sample_time: float, start: float, nominal: float
) -> tuple[float, float]:
    """Take the nominal or a round sample time where the stamps do not contradict; returns it and the start [s]."""
    span = int(numbers[-1] - numbers[0])
    for candidate in (nominal, float(f"{sample_time:.4g}"), round(sample_time, 9)):
        if abs(candidate - sample_time) * span < _SAME * sample_time:
            sample_time = candidate
            break
    offset = time - sample_time * numbers
    exact = np.abs(offset - offset[0]) < 1.5e-9
    return sample_time, float(offset[0] if np.all(exact) else np.median(offset))


def _one_per_slot(time: FloatArray, numbers: IntArray, start: float, sample_time: float) -> IntArray:
    """Keep of the messages in one slot the one nearest to its instant; returns their rows."""
    off = np.abs(time - start - sample_time * numbers)
    order = np.lexsort((off, numbers))
    first = np.ones(len(order), dtype=bool)
    first[1:] = numbers[order][1:] != numbers[order][:-1]
    return np.sort(order[first])
