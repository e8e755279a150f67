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
