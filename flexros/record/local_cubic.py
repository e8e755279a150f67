"""Interpolation by the cubic through four neighbouring samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

FEWEST = 4
"""Samples through which the cubic goes."""


def local_cubic(time: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Interpolate by the polynomial of third degree through the two samples before and the two after an instant.

    A spline would spread the rounding of every sample over all others, so that an encoder at rest seemed to move.

    Args:
        time: Sampling instants [s], increasing, at least 4, shape (n,).
        values: Samples, shape (n, M).
        at: Instants within them [s], shape (k,).

    Returns:
        Interpolated values, shape (k, M).
    """
    first = np.clip(np.searchsorted(time, at, side="right") - FEWEST // 2, 0, len(time) - FEWEST)
    points = time[first[:, None] + np.arange(FEWEST)]
    result = np.zeros((len(at), values.shape[1]))
    for k in range(FEWEST):
        weight = np.ones(len(at))
        for other in range(FEWEST):
            if other != k:
                weight *= (at - points[:, other]) / (points[:, k] - points[:, other])
        result += weight[:, None] * values[first + k]
    return result
