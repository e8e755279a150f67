"""Rough signals for checks: positions without holes, smooth motion, noise by high differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray

HIGH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)
"""Fourth difference with the gain 1 for white noise."""

_BLOCK = 64  # samples over which noise is averaged


def bridged(position: FloatArray, valid: BoolArray) -> FloatArray:
    """Bridge samples that were not measured by straight lines.

    Args:
        position: Positions, shape (n, M).
        valid: Which were measured, shape (n,).

    Returns:
        Positions, shape (n, M).
    """
    if np.all(valid):
        return position
    places = np.arange(len(position))
    return np.column_stack([np.interp(places, places[valid], column[valid]) for column in position.T])


def smooth_motion(position: FloatArray, sample_time: float, cutoff: float) -> FloatArray:
    """Low-pass without phase (Butterworth of order 4, both ways) and differentiate.

    Args:
        position: Positions without holes [rad or m], shape (n, M).
        sample_time: Time between two samples [s].
        cutoff: Corner [Hz], below a quarter of the sampling rate.

    Returns:
        Position, speed, acceleration, shape (3, n, M).
    """
    from scipy.signal import butter, sosfiltfilt  # here, because it loads slowly

    sections = butter(4, 2 * cutoff * sample_time, output="sos")
    smooth = sosfiltfilt(sections, position, axis=0)
    speed = np.gradient(smooth, sample_time, axis=0)
    acceleration = np.zeros_like(smooth)
    acceleration[1:-1] = np.diff(smooth, 2, axis=0) / sample_time**2
    return np.stack([smooth, speed, acceleration])


def noise_power(position: FloatArray) -> FloatArray:
    """Estimate the variance of white noise from fourth differences in the quieter half of a record.

    Args:
        position: Positions without holes [rad or m], shape (n, M).

    Returns:
        Variances, shape (M,); what moves faster than the noise in all of the record counts as noise too.
    """
    high = np.apply_along_axis(np.convolve, 0, position, HIGH_DIFFERENCE, mode="valid") ** 2
    blocks = high[: len(high) // _BLOCK * _BLOCK].reshape(-1, _BLOCK, position.shape[1]).mean(axis=1)
    return np.asarray(np.quantile(blocks, 0.25, axis=0) if len(blocks) else high.mean(axis=0))
