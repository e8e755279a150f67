"""Checks of the stamps of a log against its plan: rate, offset, jitter, repeats, gaps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.even_grid import NOTED_JITTER

if TYPE_CHECKING:
    from flexros.arrays import IntArray

RATE_TOLERANCE = 1e-3
"""Relative deviation of the median step from the sample time up to which the rate is the same (chosen)."""

LARGEST_JITTER = 0.1
"""Largest deviation of a stamp from its sampling instant [samples] (chosen)."""


def sample_numbers(
    stamp: IntArray, origin: int, sample_time: float, topic: str, highest: float, warnings: list[str]
) -> IntArray:
    """Turn stamps into numbers of samples.

    Args:
        stamp: Stamps [ns], increasing, shape (n,).
        origin: Stamp of sample 0 [ns].
        sample_time: T_s of the plan [s].
        topic: Name of the topic, for messages.
        highest: Highest excited frequency [Hz]; distinguishes aliasing from another rate.
        warnings: Receives a sentence about jitter.

    Returns:
        Sample numbers, increasing, shape (n,).

    Raises:
        InputError: Another rate, stamps that fall between samples, or two in one sample.
    """
    _check_rate(stamp, sample_time, topic, highest)
    position = (stamp - origin) / (sample_time * 1e9)
    numbers = np.rint(position).astype(np.int64)
    deviation = position - numbers
    worst = int(np.argmax(abs(deviation)))
    if abs(deviation[worst]) > LARGEST_JITTER:
        raise InputError(
            f"{topic} is stamped {deviation[worst] * sample_time * 1e3:+.3g} ms off the sampling instant at "
            f"{(stamp[worst] - origin) * 1e-9:.4f} s, allowed is {LARGEST_JITTER:g} of the sample time of "
            f"{sample_time * 1e3:g} ms; correct the time offset of the topic when importing, or give the start stamp"
        )
    jitter = float(np.sqrt(np.mean(deviation**2)))
    if jitter > NOTED_JITTER:
        warnings.append(
            f"the stamps of {topic} jitter by {jitter * sample_time * 1e6:.3g} us rms, which blurs high frequencies"
        )
    repeated = np.flatnonzero(np.diff(numbers) == 0)
    if len(repeated):
        raise InputError(
            f"{topic} has {len(repeated)} repeated stamps, the first at {(stamp[repeated[0]] - origin) * 1e-9:.4f} s, "
            "allowed is one message per sample; drop the repeats"
        )
    return numbers


def _check_rate(stamp: IntArray, sample_time: float, topic: str, highest: float) -> None:
    if len(stamp) < 2:
        raise InputError(f"too short a log: {topic} has {len(stamp)} messages, whole periods are needed; record longer")
    step = float(np.median(np.diff(stamp))) * 1e-9
    if abs(step / sample_time - 1.0) <= RATE_TOLERANCE:
        return
    if highest >= 0.5 / step:
        raise InputError(
            f"aliasing: {topic} is sampled at {1 / step:.6g} Hz, so what is excited up to {highest:g} Hz folds back "
            f"from the Nyquist frequency of {0.5 / step:.6g} Hz; record at the {1 / sample_time:.6g} Hz of the plan"
        )
    raise InputError(
        f"{topic} is sampled at {1 / step:.6g} Hz, the plan says {1 / sample_time:.6g} Hz; record every sample, or "
        "give the plan with the sample time of the log"
    )


def check_equal_rates(states: IntArray, commands: IntArray) -> None:
    """Reject topics of unequal rates.

    Args:
        states: Stamps of joint_states [ns], shape (n,).
        commands: Stamps of joint_commands [ns], shape (k,).

    Raises:
        InputError: The median steps differ.
    """
    if min(len(states), len(commands)) < 2:
        return
    steps = [float(np.median(np.diff(stamp))) * 1e-9 for stamp in (states, commands)]
    if abs(steps[1] / steps[0] - 1.0) > RATE_TOLERANCE:
        raise InputError(
            f"unequal rates: joint_states is sampled at {1 / steps[0]:.6g} Hz and joint_commands at {1 / steps[1]:.6g} "
            "Hz, allowed is one command for each measurement; record both at the rate of the loop"
        )


def check_no_gap(numbers: IntArray, first: int, stop: int, sample_time: float, what: str) -> None:
    """Reject missing samples within recorded periods.

    Args:
        numbers: Numbers of the recorded samples, increasing, shape (n,).
        first: First sample needed.
        stop: Sample after the last one needed.
        sample_time: T_s [s].
        what: What the samples belong to, e.g. "position 1, block 1, experiment 2".

    Raises:
        InputError: The log ends before, begins later, or has gaps.
    """
    if numbers[-1] < stop - 1:
        raise InputError(
            f"too short a log: it ends at {numbers[-1] * sample_time:.3f} s, {what} lasts until "
            f"{(stop - 1) * sample_time:.3f} s, so periods are missing; record to the end, or use the "
            "complete blocks (setting partial=true)"
        )
    if numbers[0] > first:
        raise InputError(
            f"the log begins at {numbers[0] * sample_time:.3f} s, {what} at {first * sample_time:.3f} s, so periods "
            "are missing; record from the start"
        )
    rows = slice(*np.searchsorted(numbers, (first, stop)))
    missing = (stop - first) - len(numbers[rows])
    if missing:
        recorded = numbers[rows]
        at = int(np.flatnonzero(np.diff(np.concatenate([[first - 1], recorded, [stop]])) > 1)[0])
        begin = first if at == 0 else int(recorded[at - 1]) + 1
        raise InputError(
            f"gap: {missing} samples of joint_states are missing in {what}, the first at {begin * sample_time:.4f} s; "
            "record without losses, or leave the block out"
        )
