"""Delay of held torques by any number of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

POLE = 0.95
"""Size of the pole at half the sampling rate; 1 is exact, but not damped [1] (chosen)."""


def delayed(torque: FloatArray, samples: float, motors: Sequence[int]) -> FloatArray:
    """Delay torques by any number of samples.

    A torque that is held from sample to sample and delayed by the fraction f of a sample moves a mass, at the samples,
    like the held output of the filter

        F(z) = ((1 - f)^2 z^2 + (1 + 2 f - 2 f^2) z + f^2) / (z (z + 1))

    which is the ratio of the responses T^2 / 2 (...) / (z - 1)^2 of the position to both, from integrating the two
    pieces of a sample. Its pole is moved from -1 to -0.95, and its zeros such that value, slope and curvature at
    frequency zero remain those of the delay. Interpolating between neighbouring commands, (1 - f) + f / z, would spread
    the torque over time like a lag.

    Args:
        torque: Torques, each held from its sample to the next [Nm or N], shape (n, M).
        samples: The delay [samples], zero or more.
        motors: Indices of the motors whose torques are delayed.

    Returns:
        Torques to hold, shape (n, M); the first torque also acts before the first sample.
    """
    whole = int(np.floor(samples))
    fraction = samples - whole
    rows = np.maximum(np.arange(len(torque)) - whole, 0)
    result = np.array(torque)
    for motor in motors:
        late = torque[rows, motor]
        result[:, motor] = late[0] + lfilter(*_filter(fraction), late - late[0]) if fraction > 0.0 else late
    return result


def _filter(fraction: float) -> tuple[FloatArray, FloatArray]:
    """Numerator and denominator in powers of 1/z."""
    share = POLE / (1.0 + POLE)
    last = 0.5 * (fraction**2 - fraction) + fraction * share
    middle = fraction + share - 2.0 * last
    numerator = np.array([1.0 - middle - last, middle, last]) * (1.0 + POLE)
    return numerator, np.array([1.0, POLE])
