"""Runs of equal samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, IntArray


def runs(same: BoolArray) -> tuple[IntArray, IntArray]:
    """Find stretches that are marked.

    Args:
        same: Marks, shape (n,).

    Returns:
        First place and length of each stretch, shapes (k,) and (k,).
    """
    edges = np.diff(np.concatenate([[False], same, [False]]).astype(np.int8))
    begin = np.flatnonzero(edges == 1)
    return begin, np.flatnonzero(edges == -1) - begin


def longest_repeat(same: BoolArray) -> tuple[int, int]:
    """Find the longest stretch that is marked.

    Args:
        same: Marks, shape (n,).

    Returns:
        Its length and its first place; (0, 0) where nothing is marked.
    """
    begin, length = runs(same)
    if not len(begin):
        return 0, 0
    best = int(np.argmax(length))
    return int(length[best]), int(begin[best])
