"""Even grid of the stamps of a topic: sample time, slot of every message, missing and jittering ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.missing_samples import LEAST_STRETCH, MOST_BRIDGED

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray

LOWEST_RATE = 19.0
"""Lowest rate of a log [Hz]: servo logs of 20 Hz with a margin for jitter (chosen)."""

HIGHEST_RATE = 2.1e4
"""Highest rate of a log [Hz]; beyond it the unit of time is more likely wrong (chosen)."""

NOTED_JITTER = 0.005
"""Deviation of stamps from even sampling, rms in samples, up to which they count as even (chosen)."""

MOST_MISSING = 0.5
"""Share of missing samples above which stamps are not sampling instants (chosen)."""

MOST_SKIPPED = 0.01
"""Share of messages before which an even grid skips a slot although the one before is near, above which sampling is
irregular (chosen)."""

MOST_EMPTY = 10_000_000
"""Most slots without a message [1] (chosen): hours at 1 kHz. Each has a row in every signal."""

_HOLE = 1.9  # intervals of irregular sampling from which messages are missing, over the mean one
_ALONE = 0.75  # distance from the nearest message, in samples, from which an instant was not measured
_FIRST = 32  # messages at the beginning of the search for the sample time
_GROWTH = 1.5  # growth of the fitted stretch; keeps the error at its end far below a sample
_NEAR = 0.35  # deviation in samples up to which a stamp counts in the fit
_SAME = 0.01  # largest error of a round sample time at the end of the log, in samples


@dataclass(frozen=True, eq=False)
class EvenGrid:
    """Even grid of sampling instants of a topic.

    Attributes:
        origin: Stamp of time zero [ns].
        start: Instant of slot 0 after `origin` [s].
        sample_time: Time between two slots [s].
        rows: Messages that are used, at most one per slot, increasing, shape (m,).
        numbers: Their slots, increasing from 0, shape (m,).
        deviation: Stamp of each minus the instant of its slot [s], shape (m,).
        warnings: What is doubtful, one sentence each.
        irregular: Whether intervals differ by more than jitter about even instants, as where a recorder of 94 Hz
            samples a clock of 500 Hz; numbers then count the messages, and deviations may exceed a sample.
    """

    origin: int
    start: float
    sample_time: float
    rows: IntArray
    numbers: IntArray
    deviation: FloatArray
    warnings: tuple[str, ...] = ()
    irregular: bool = False

    @property
    def n_slots(self) -> int:
        """Number of slots from the first message to the last."""
        return int(self.numbers[-1]) + 1

    @property
    def instants(self) -> FloatArray:
        """Instants of all slots after `origin` [s], shape (n_slots,)."""
        return np.asarray(self.start + self.sample_time * np.arange(self.n_slots), dtype=np.float64)

    @property
    def times(self) -> FloatArray:
        """Stamps of the messages that are used, after `origin` [s], shape (m,)."""
        return np.asarray(self.start + self.sample_time * self.numbers + self.deviation, dtype=np.float64)

    @property
    def jitter(self) -> float:
        """Rms deviation of the stamps [s]."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    def held(self) -> tuple[IntArray, BoolArray]:
        """Return the last message of each slot, and whether it belongs to that slot.

        Returns:
            Indices into `rows`, shape (n_slots,), and whether the message belongs to the slot, shape (n_slots,).
        """
        slots = np.arange(self.n_slots)
        index = np.searchsorted(self.numbers, slots, side="right") - 1
        return index, self.numbers[index] == slots

    def near(self, usable: BoolArray) -> BoolArray:
        """Mark the slots with a usable message near their instant, by the true times.

        Args:
            usable: Which of the messages that are used count, shape (m,).

        Returns:
            Marks, shape (n_slots,).
        """
        times, at = self.times[usable], self.instants
        later = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
        distance = np.minimum(np.abs(at - times[later - 1]), np.abs(times[later] - at))
        return np.asarray(distance < _ALONE * self.sample_time)

    def interpolated(self, values: FloatArray) -> FloatArray:
        """Interpolate a signal linearly to the instants of the slots, by the true times.

        Args:
            values: Signal, one row per message that is used; rows that are not finite are left out, shape (m, k).

        Returns:
            Signal, shape (n_slots, k).
        """
        finite = np.all(np.isfinite(values), axis=1)
        return np.column_stack([np.interp(self.instants, self.times[finite], column) for column in values[finite].T])


def even_grid(stamp: IntArray, nominal: float, topic: str) -> EvenGrid:
    """Fit an even grid to stamps.

    Args:
        stamp: Stamps [ns], increasing, shape (n,).
        nominal: Nominal sample time, used where the stamps agree with it [s].
        topic: Log and topic, for messages.

    Returns:
        The grid.

    Raises:
        InputError: Too few messages, a rate outside the limits, or stamps that fit no even grid.
    """
    if len(stamp) < _FIRST:
        raise InputError(f"{topic} has {len(stamp)} messages, at least {_FIRST} are needed; record a longer log")
    time = (stamp - stamp[0]) * 1e-9
    typical = float(np.median(np.diff(time)))
    _check_rate(typical, topic)
    numbers, sample_time = _numbers(time, typical)
    warnings: list[str] = []
    slots = _distinct(numbers)
    missing = 1 - len(slots) / (numbers[-1] - numbers[0] + 1 - _paused(slots))
    if missing > MOST_MISSING or len(slots) < (1 - MOST_MISSING) * len(numbers):
        numbers, sample_time = _by_count(time, topic, missing)
        warnings.append(
            f"{topic}: the stamps come in bursts, as the receive times of a recorder do; the samples are treated as "
            f"even at {1 / sample_time:.6g} Hz, so their timing is doubtful"
        )
    irregular = _is_irregular(time, numbers, sample_time)
    if irregular:
        numbers, sample_time = _by_interval(time)
    sample_time, start = _round(time, numbers, sample_time, nominal)
    rows = _one_per_slot(time, numbers, start, sample_time)
    if len(rows) < len(numbers):
        warnings.append(
            f"{topic}: {len(numbers) - len(rows)} messages, late or repeated, share a sampling instant with another; "
            "the one nearest to the instant was kept"
        )
    numbers = numbers[rows]
    if numbers[-1] - numbers[0] + 1 - len(rows) > MOST_EMPTY:
        at = int(np.argmax(np.diff(numbers)))
        raise InputError(
            f"{topic}: the stamps jump by {time[rows][at + 1] - time[rows][at]:.4g} s behind message {rows[at] + 1}, "
            "as where a clock was set or two recordings are in one file; cut the log there"
        )
    start, numbers = start + sample_time * int(numbers[0]), numbers - numbers[0]
    deviation = time[rows] - start - sample_time * numbers
    return EvenGrid(int(stamp[0]), start, sample_time, rows, numbers, deviation, tuple(warnings), irregular)


def _distinct(numbers: IntArray) -> IntArray:
    """Return increasing numbers without repetitions; those of nearly all logs are so already."""
    return numbers if np.all(np.diff(numbers) > 0) else np.unique(numbers)


def _paused(slots: IntArray) -> int:
    """Count the slots of pauses between experiments, as `flexros.record.missing_samples.pauses` marks them.

    It needs no row per slot: stamps in a wrong unit would make billions.
    """
    skipped = np.diff(slots) - 1
    holes = np.flatnonzero(skipped > MOST_BRIDGED)
    stretches = np.diff(np.concatenate([[-1], holes, [len(slots) - 1]])) >= LEAST_STRETCH
    return int(skipped[holes[stretches[:-1] & stretches[1:]]].sum())


def _is_irregular(time: FloatArray, numbers: IntArray, step: float) -> bool:
    """Whether an even grid skips slots between messages that are near to each other."""
    skipped = (np.diff(numbers) > 1) & (np.diff(time) < 1.5 * step)
    return bool(skipped.sum() > MOST_SKIPPED * len(numbers))


def _by_interval(time: FloatArray) -> tuple[IntArray, float]:
    """Number messages consecutively, with empty slots in holes only; return numbers and sample time [s]."""
    interval = np.diff(time)
    usual = float(np.mean(interval[interval < _HOLE * np.median(interval)]))
    steps = np.where(interval < _HOLE * usual, 1, np.rint(interval / usual)).astype(np.int64)
    numbers = np.concatenate([[0], np.cumsum(steps)])
    slope, _ = np.polyfit(numbers, time, 1)
    return numbers, float(slope)


def _check_rate(step: float, topic: str) -> None:
    """Reject rates outside the limits, with a hint where a unit of time explains them."""
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


def _numbers(time: FloatArray, step: float) -> tuple[IntArray, float]:
    """Number messages by the nearest slot, in growing stretches; return numbers and sample time [s]."""
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
            return np.rint((time - start) / step).astype(np.int64), step
        end = min(n, int(np.ceil(_GROWTH * end)))


def _by_count(time: FloatArray, topic: str, missing: float) -> tuple[IntArray, float]:
    """Number messages consecutively where the stamps come in bursts around a straight line; return also sample time."""
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
    return numbers, float(slope)


def _round(time: FloatArray, numbers: IntArray, sample_time: float, nominal: float) -> tuple[float, float]:
    """Use the nominal or a round sample time where the stamps agree; return it and the start [s]."""
    span = int(numbers[-1] - numbers[0])
    for candidate in (nominal, float(f"{sample_time:.4g}"), round(sample_time, 9)):
        if abs(candidate - sample_time) * span < _SAME * sample_time:
            sample_time = candidate
            break
    offset = time - sample_time * numbers
    exact = np.abs(offset - offset[0]) < 1.5e-9
    return sample_time, float(offset[0] if np.all(exact) else np.median(offset))


def _one_per_slot(time: FloatArray, numbers: IntArray, start: float, sample_time: float) -> IntArray:
    """Return the rows of the messages nearest to their instants, one per slot."""
    off = np.abs(time - start - sample_time * numbers)
    order = np.lexsort((off, numbers))
    nearest = np.ones(len(order), dtype=bool)
    nearest[1:] = numbers[order][1:] != numbers[order][:-1]
    return np.sort(order[nearest])
