"""Smooth time law from a profile with jumps of the acceleration."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory.time_law import TimeLaw

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.time_optimal.profile import FastestProfile

NAME = "time_optimal"
"""Name of the time law in messages."""


def smoothed_law(profile: FastestProfile, smoothing: float, extent: float) -> TimeLaw:
    """Return the moving average of a profile, twice over half the smoothing time, as an exact time law.

    The mean of sigma(t) over a time h, taken twice, has a bounded fourth derivative: with the piecewise constant
    acceleration a(t) of the profile it is (a(t) - 2 a(t - h) + a(t - 2 h)) / h^2. A step of the acceleration becomes a
    ramp over 2 h with a jerk of at most step / h. The motion goes from rest to rest over the same way, takes 2 h
    longer, and never turns back.

    Args:
        profile: Fastest profile of the share of the path.
        smoothing: Time 2 h over which a step of the acceleration is spread [s], above 0.
        extent: Largest value of the path parameter [p].

    Returns:
        The law from 0 to the extent, polynomials of fourth degree.
    """
    half = 0.5 * smoothing
    begins = profile.time
    knots = np.unique(np.concatenate((begins, begins + half, begins + smoothing)))
    knots = knots[np.concatenate(([True], np.diff(knots) > 1e-9 * half))]
    middle = 0.5 * (knots[1:] + knots[:-1])

    def acceleration(t: FloatArray) -> FloatArray:
        piece = np.clip(np.searchsorted(begins, t, side="right") - 1, 0, profile.acceleration.size - 1)
        return np.where((t > 0.0) & (t < begins[-1]), profile.acceleration[piece], 0.0)

    snap = (acceleration(middle) - 2.0 * acceleration(middle - half) + acceleration(middle - smoothing)) / half**2
    width, first = np.diff(knots), snap.size // 2
    forward = _integrated(snap[:first], width[:first])
    backward = _integrated(-snap[first:][::-1], width[first:][::-1])  # in reversed time, from the end
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    coefficients = np.vstack((extent * forward, (-extent * backward * signs)[::-1]))
    coefficients[first:, 0] += extent
    return TimeLaw(
        knots=knots,
        origins=np.concatenate((knots[:first], knots[first + 1 :])),
        coefficients=coefficients,
        start=0.0,
        end=extent,
        bounded_derivatives=4,
        name=NAME,
    )


def slowed(law: TimeLaw, factor: float) -> TimeLaw:
    """Return the law with all times longer by a factor."""
    powers = factor ** -np.arange(law.coefficients.shape[1], dtype=float)
    return replace(law, knots=law.knots * factor, origins=law.origins * factor, coefficients=law.coefficients * powers)


def reversed_way(law: TimeLaw) -> TimeLaw:
    """Return the law that travels the same path from its end to its start with the same speed over time."""
    coefficients = -law.coefficients
    coefficients[:, 0] += law.end
    return replace(law, coefficients=coefficients, start=law.end, end=0.0)


def _integrated(snap: FloatArray, width: FloatArray) -> FloatArray:
    """Return coefficients of successive pieces of fourth degree that begin at rest at 0, shape (n, 5)."""
    rows = np.empty((snap.size, 5))
    s = v = a = j = 0.0
    for i, (top, h) in enumerate(zip(snap.tolist(), width.tolist(), strict=True)):
        rows[i] = s, v, a / 2.0, j / 6.0, top / 24.0
        s, v, a, j = (
            s + h * (v + h * (a / 2.0 + h * (j / 6.0 + h * top / 24.0))),
            v + h * (a + h * (j / 2.0 + h * top / 6.0)),
            a + h * (j + h * top / 2.0),
            j + h * top,
        )
    return rows
