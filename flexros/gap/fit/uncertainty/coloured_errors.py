"""Covariance of gradients for errors that are not white, by their smoothed spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import uniform_filter1d

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

FEWEST_LINES = 12
"""Least number of lines of a periodogram that are averaged, half of them to each side [1]."""
BANDS = 12
"""Frequency bands with windows of their own, each up to twice the frequency of the last [1]."""


def coloured(J: FloatArray, left: FloatArray, used: int) -> FloatArray:
    """Return the covariance of J'r for errors r with the spectrum of what is left, `used` of them not zero.

    Args:
        J: Derivatives of the errors of one motor, shape (n, n_fitted).
        left: What is left of them, in columns that add in power, shape (n, k).
        used: Number of errors that are used.
    """
    transform = np.fft.rfft(J, axis=0)
    power = np.array([smoothed(np.abs(np.fft.rfft(column)) ** 2) for column in left.T]).sum(axis=0)
    spectrum = power / max(used, 1)
    weight = np.full(len(spectrum), 2.0)
    weight[0] = 1.0
    weight[-1] = 1.0 if len(J) % 2 == 0 else 2.0
    return np.asarray(np.real(np.conj(transform).T @ (transform * (weight * spectrum)[:, None])) / len(J))


def smoothed(periodogram: FloatArray) -> FloatArray:
    """Average a periodogram over windows that widen with the frequency.

    Args:
        periodogram: Power of each line from zero frequency on, shape (n,).

    Returns:
        The average around each line, shape (n,).
    """
    result = np.array(periodogram, dtype=float)
    begin, width = 0, FEWEST_LINES
    for _ in range(BANDS):
        end = min(len(periodogram), 4 * width)
        around = uniform_filter1d(periodogram, min(width, len(periodogram)), mode="reflect")
        result[begin:end] = around[begin:end]
        if end == len(periodogram):
            break
        begin, width = end, 2 * width
    else:
        result[begin:] = uniform_filter1d(periodogram, width, mode="reflect")[begin:]
    return result
