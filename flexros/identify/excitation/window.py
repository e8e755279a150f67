"""Smooth fade in and fade out, with derivative and integral in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory.polynomial import NINTH_DEGREE

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

STEP = np.polynomial.Polynomial(NINTH_DEGREE)
"""From 0 at 0 to 1 at 1 with four derivatives that are zero at both ends; its integral from 0 to 1 is 1/2."""

_SLOPE, _AREA = STEP.deriv(), STEP.integ()


def window(n_samples: int, ramp: int, sample_time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a window that rises from 0 to 1, stays at 1, and falls symmetrically.

    Args:
        n_samples: Length N of the window; it is 0 at sample 0 and would be 0 again at sample N.
        ramp: Length of rise and fall [samples], at most N / 2.
        sample_time: Time between two samples [s].

    Returns:
        Window w [1], its derivative [1/s] and its integral from sample 0 on [s], each of shape (N,).
    """
    k = np.arange(n_samples, dtype=float)
    up, down = np.clip(k / ramp, 0.0, 1.0), np.clip((n_samples - k) / ramp, 0.0, 1.0)
    rising = k < 0.5 * n_samples
    value = np.where(rising, STEP(up), STEP(down))
    slope = np.where(rising, _SLOPE(up), -_SLOPE(down)) / (ramp * sample_time)
    before = ramp * _AREA(up) + np.maximum(k - ramp, 0.0)
    after = ramp * _AREA(down) + np.maximum(n_samples - ramp - k, 0.0)
    area = np.where(rising, before, (n_samples - ramp) - after) * sample_time
    return value, slope, area
