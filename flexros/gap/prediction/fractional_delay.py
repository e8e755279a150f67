"""Held torques that act like delayed ones, for delays that are no whole number of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

POLE = 0.95
"""Size of the pole at half the sampling rate; 1 is exact and would ring for ever [1] (chosen)."""


def delayed(torque: FloatArray, samples: float, motors: Sequence[int]) -> FloatArray:
    """Delay torques by any number of samples.

    A torque that is held from sample to sample and delayed by the fraction f of a sample moves a mass, at the samples,
    like the held torque that the filter

        F(z) = ((1 - f)^2 z^2 + (1 + 2 f - 2 f^2) z + f^2) / (z (z + 1))

    makes of it: the ratio of the responses T^2 / 2 (...) / (z - 1)^2 of the position to both, found by integrating the
    two pieces of a sample. Its pole is moved from -1 to -0.95 and its zeros so that value, slope and curvature at
    frequency zero, which are those of the delay, stay. Mixing two neighbouring commands, (1 - f) + f / z, would spread
    the torque over time and so imitate a lag.

    Args:
        torque: Torques, each held from its sample to the next [Nm or N], shape (n, M).
        samples: The delay [samples], zero or more.
        motors: Numbers of the motors whose torques are delayed (0-based).

    Returns:
        Torques to hold, shape (n, M); before the first sample that torque is taken to act.
    """
    whole = int(np.floor(samples))
    fraction = samples - whole
    rows = np.maximum(np.arange(len(torque)) - whole, 0)
    result = np.array(torque)
    for motor in motors:
        one = torque[rows, motor]
        result[:, motor] = one[0] + lfilter(*_filter(fraction), one - one[0]) if fraction > 0.0 else one
    return result


def _filter(fraction: float) -> tuple[FloatArray, FloatArray]:
    """Numerator and denominator in powers of 1/z."""
    share = POLE / (1.0 + POLE)
    last = 0.5 * (fraction**2 - fraction) + fraction * share
    middle = fraction + share - 2.0 * last
    numerator = np.array([1.0 - middle - last, middle, last]) * (1.0 + POLE)
    return numerator, np.array([1.0, POLE])
