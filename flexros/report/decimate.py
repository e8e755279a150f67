"""Reduction of long series to the points of a picture, without losing peaks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

SCREEN_POINTS = 3000
"""Largest number of points per curve; a wide screen has about as many columns."""


def screen_samples(values: FloatArray, limit: int = SCREEN_POINTS) -> IntArray:
    """Choose the samples of a series to draw: first, last, smallest and largest of each of many equal pieces.

    Args:
        values: The series, shape (n,), n >= 1.
        limit: Largest number of samples, at least 4.

    Returns:
        Chosen indices, increasing; all of them if there are not more than `limit`.
    """
    n = len(values)
    if n <= limit:
        return np.arange(n)
    width = int(np.ceil(n / (limit // 2 - 1)))
    pieces = np.pad(values, (0, -n % width), mode="edge").reshape(-1, width)
    first = np.arange(len(pieces)) * width
    chosen = np.concatenate([[0, n - 1], first + pieces.argmin(axis=1), first + pieces.argmax(axis=1)])
    return np.unique(np.minimum(chosen, n - 1))
