"""Smoothed motion and noise power of measured positions."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

HIGH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)
"""Fourth difference with the gain 1 for white noise."""
MOTION_BAND = 20.0
"""Highest frequency of the motion of a robot [Hz] (chosen: planned motions are slower)."""

_BLOCK = 64  # samples over which noise is averaged


def motion_cutoff(sample_time: float) -> float:
    """Return the corner of the low-pass that passes the motion of a robot [Hz], at most a tenth of the rate.

    Args:
        sample_time: Time between two samples [s].
    """
    return min(MOTION_BAND, 0.1 / sample_time)


def smooth_motion(position: FloatArray, sample_time: float, cutoff: float) -> FloatArray:
    """Apply a zero-phase low-pass (Butterworth of order 4, forwards and backwards) and differentiate.

    Args:
        position: Positions without holes [rad or m], shape (n, M).
        sample_time: Time between two samples [s].
        cutoff: Corner frequency [Hz], below a quarter of the sampling rate.

    Returns:
        Position, velocity and acceleration, shape (3, n, M).
    """
    corner = 2 * cutoff * sample_time
    motion = np.zeros((3, *position.shape))
    for motor, column in enumerate(position.T):  # one by one: the filter makes several copies
        smooth = _to_and_fro(column, corner)
        motion[0, :, motor], motion[1, :, motor] = smooth, np.gradient(smooth, sample_time)
        motion[2, 1:-1, motor] = np.diff(smooth, 2) / sample_time**2
    return motion


def _to_and_fro(column: FloatArray, corner: float) -> FloatArray:
    """Filter forwards and backwards, as `scipy.signal.sosfiltfilt` does to the last bit.

    That one designs the state at rest anew each time, which takes longer than to filter a short log.

    Args:
        column: Values, shape (n,).
        corner: Corner frequency over half the sampling rate [1].

    Raises:
        ValueError: There are fewer values than it continues at either end.
    """
    from scipy.signal import sosfilt  # here, because it loads slowly

    sections, at_rest = _low_pass(corner)
    edge = 3 * (2 * len(sections) + 1)
    if len(column) <= edge:
        raise ValueError(f"{len(column)} values are too few, at least {edge + 1} are needed")
    first, last = column[:1], column[-1:]
    longer = np.concatenate([2 * first - column[edge:0:-1], column, 2 * last - column[-2 : -edge - 2 : -1]])
    for _ in range(2):
        longer = sosfilt(sections, longer, zi=at_rest * longer[0])[0][::-1]
    return np.asarray(longer[edge:-edge])


@lru_cache(maxsize=64)
def _low_pass(corner: float) -> tuple[FloatArray, FloatArray]:
    """Design a Butterworth filter of order 4; checks of a log ask for few of them, often.

    Args:
        corner: Corner frequency over half the sampling rate [1].

    Returns:
        Its second-order sections, and their state at rest at 1.
    """
    from scipy.signal import butter, sosfilt_zi  # here, because it loads slowly

    sections = np.asarray(butter(4, corner, output="sos"))
    return sections, np.asarray(sosfilt_zi(sections))


def noise_power(position: FloatArray) -> FloatArray:
    """Estimate the variance of white noise from fourth differences in the quieter half of a record.

    Args:
        position: Positions without holes [rad or m], shape (n, M).

    Returns:
        Variances, shape (M,). Fast motion that lasts throughout the record counts as noise.
    """
    high = np.apply_along_axis(np.convolve, 0, position, HIGH_DIFFERENCE, mode="valid") ** 2
    blocks = high[: len(high) // _BLOCK * _BLOCK].reshape(-1, _BLOCK, position.shape[1]).mean(axis=1)
    return np.asarray(np.quantile(blocks, 0.25, axis=0) if len(blocks) else high.mean(axis=0))
