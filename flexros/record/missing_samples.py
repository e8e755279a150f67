"""Samples that were not measured: runs of them, bridging of short ones, and long holes that do not count."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.local_cubic import FEWEST, local_cubic

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray

MOST_BRIDGED = 5
"""Most samples in a row that may be missing and still be bridged (chosen): positions are interpolated by a cubic, a
command is held. A longer hole is a loss of the recorder, in which neither motion nor torque is known."""

PAUSE = 20.0
"""Interval of stamps over the usual one from which it is a pause, through which nothing is known [1] (chosen)."""

LEAST_STRETCH = 50
"""Fewest samples between two long holes, from which these are pauses between experiments and not losses (chosen)."""


def runs(marked: BoolArray) -> tuple[IntArray, IntArray]:
    """Find stretches that are marked.

    Args:
        marked: Marks, shape (n,).

    Returns:
        First row and length of each stretch, shapes (k,) and (k,).
    """
    edges = np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8))
    begin = np.flatnonzero(edges == 1)
    return begin, np.flatnonzero(edges == -1) - begin


def longest_run(marked: BoolArray) -> int:
    """Return the length of the longest stretch that is marked, shape (n,)."""
    return int(runs(marked)[1].max(initial=0))


def long_holes(valid: BoolArray, most: int = MOST_BRIDGED) -> BoolArray:
    """Mark the samples of holes that are too long to be bridged.

    Args:
        valid: Which samples were measured, shape (n,).
        most: Most samples in a row that may be missing.

    Returns:
        Samples that belong to more missing ones in a row, shape (n,).
    """
    marked = np.zeros(len(valid), dtype=bool)
    for begin, length in zip(*runs(~valid), strict=True):
        if length > most:
            marked[begin : begin + length] = True
    return marked


def pauses(valid: BoolArray) -> BoolArray:
    """Mark the samples of pauses: long holes that have a long stretch of measured samples on either side.

    Args:
        valid: Which samples were measured, shape (n,).

    Returns:
        Samples that belong to a pause, shape (n,).
    """
    holes = long_holes(valid)
    stretches = np.zeros(len(valid), dtype=bool)
    for begin, length in zip(*runs(~holes), strict=True):
        stretches[begin : begin + length] = length >= LEAST_STRETCH
    marked = np.zeros(len(valid), dtype=bool)
    for begin, length in zip(*runs(holes), strict=True):
        end = begin + length
        marked[begin:end] = begin > 0 and end < len(valid) and stretches[begin - 1] and stretches[end]
    return marked


def bridged(values: FloatArray, valid: BoolArray) -> FloatArray:
    """Interpolate linearly over samples that were not measured.

    Args:
        values: Signals, shape (n, M).
        valid: Which samples were measured, shape (n,).

    Returns:
        Signals without holes, shape (n, M).
    """
    if np.all(valid):
        return values
    rows = np.arange(len(values))
    return np.column_stack([np.interp(rows, rows[valid], column[valid]) for column in values.T])


def bridged_motion(position: FloatArray, valid: BoolArray) -> FloatArray:
    """Interpolate positions over samples that were not measured: by a cubic over short holes, linearly over long ones.

    A straight line over a short hole has a corner on either side, with accelerations far above those of the motion.

    Args:
        position: Positions [rad or m], shape (n, M).
        valid: Which samples were measured, shape (n,).

    Returns:
        Positions without holes, shape (n, M).
    """
    measured, short = np.flatnonzero(valid), np.flatnonzero(~valid & ~long_holes(valid))
    if not len(short) or len(measured) < FEWEST:
        return bridged(position, valid)
    short = short[(short > measured[0]) & (short < measured[-1])]
    filled = bridged(position, valid)
    filled[short] = local_cubic(measured.astype(float), position[valid], short.astype(float))
    return filled
