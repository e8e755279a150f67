"""Values of an encoder that repeat: at rest or at a turning point, or because it is clipped or stuck."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.smoothing import noise_power

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

BESIDE = 4
"""Samples before and after repeated values whose change is looked at (chosen)."""

STEPS = 6.5
"""Change within `BESIDE` samples, in steps of the encoder, up to which it is at rest (chosen): beside a turning point
that takes 8 samples or more it is at most 4, and more where friction lets the motor stick."""

USUAL = 0.99
"""Share of accelerations that are usual: a motor that friction stops decelerates like this (chosen)."""

SLOW = 0.02
"""The same over the largest change within as many samples, for a signal without noise, as a simulator writes it
(chosen)."""

NEAR = 64
"""Samples before and after repeated values in which the resolution there is looked for (chosen)."""

REPEATED = 0.25
"""Share of these samples equal to the one before from which the signal is coarse there (chosen)."""

NOISELESS = 1e-4
"""Noise over that largest change below which a filtered signal has practically none (chosen)."""


def slow_change(values: FloatArray, step: float) -> float:
    """Return the change within `BESIDE` samples up to which a signal comes to rest.

    Args:
        values: Positions [rad or m], shape (n,).
        step: Resolution of the encoder [rad or m]; 0 without one.
    """
    largest = float(np.abs(values[BESIDE:] - values[:-BESIDE]).max(initial=0.0))
    turned = np.abs(values[2 * BESIDE :] - 2 * values[BESIDE:-BESIDE] + values[: -2 * BESIDE])
    noiseless = float(noise_power(values[:, None])[0]) < (NOISELESS * largest) ** 2
    if step > 0:
        return max(STEPS * step, float(np.quantile(turned, USUAL)) / 2)
    return SLOW * largest if noiseless else 0.0


def comes_to_rest(values: FloatArray, begin: int, length: int, slow: float, *, at_end: bool = False) -> bool:
    """Return whether a signal comes to a stretch of repeated values slowly, as before rest and at a turning point.

    A signal that is cut off passes its largest value as fast as it comes back. Friction may stop a motor at once, or
    let it break free at once, but not both.

    Args:
        values: Positions [rad or m], shape (n,).
        begin: First sample of the stretch.
        length: Number of its samples.
        slow: Change of `slow_change` [rad or m].
        at_end: Whether it is at the end of its range, where it rests if it either comes or leaves slowly.
    """
    before = values[max(0, begin - BESIDE) : begin] - values[begin]
    after = values[begin + length : begin + length + BESIDE] - values[begin]
    near = min(max(length, 2 * BESIDE), NEAR)  # of a joint that turns faster, samples farther away differ
    resolution = max(_resolution_beside(values, begin, length, beside) for beside in (near, NEAR))
    slow = max(slow, STEPS * resolution)
    if at_end:
        return min(float(np.abs(side).max(initial=0.0)) for side in (before, after)) <= slow
    if len(after) == BESIDE and abs(after[0]) <= abs(after[1] - after[0]):
        after = after[:0]  # it breaks free of its friction: what it leaves fast, it came to slowly
    return float(np.abs(np.concatenate([before, after])).max(initial=0.0)) <= slow


def _resolution_beside(values: FloatArray, begin: int, length: int, beside: int) -> float:
    """Return the usual change beside a stretch where many samples repeat the one before; 0 where they do not.

    Numbers that a recorder rounds to some digits have no common step, and a sum of two encoders has none either.
    """
    sides = values[max(0, begin - beside) : begin], values[begin + length : begin + length + beside]
    changes = np.abs(np.concatenate([np.diff(side)[side[1:] != values[begin]] for side in sides]))
    moved = changes[changes > 0]
    return float(np.median(moved)) if len(moved) and len(moved) < (1 - REPEATED) * len(changes) else 0.0
