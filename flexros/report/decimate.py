"""Fewer points for a picture than a log has samples, without losing a peak."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

SCREEN_POINTS = 3000
"""Points drawn per curve at most; a wide screen shows about as many columns."""


def screen_samples(values: FloatArray, limit: int = SCREEN_POINTS) -> IntArray:
    """Choose the samples of a series to draw: first, last, and the smallest and largest of each of many equal pieces.

    Args:
        values: The series, shape (n,), n >= 1.
        limit: Number of samples to choose at most, at least 4.

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
