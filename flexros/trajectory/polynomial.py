"""Polynomial time laws: quintic and 9th degree."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.limits import LIMIT_NAMES, Limits
from flexros.trajectory.time_law import TimeLaw, positive

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

QUINTIC = (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)
"""10 x^3 - 15 x^4 + 6 x^5: speed and acceleration are zero at both ends, the jerk is not."""

NINTH_DEGREE = (0.0, 0.0, 0.0, 0.0, 0.0, 126.0, -420.0, 540.0, -315.0, 70.0)
"""126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9: four derivatives are zero at both ends."""


def quintic(distance: float, duration: float | None = None, limits: Limits | None = None) -> TimeLaw:
    """Return the quintic time law s(t) = L (10 x^3 - 15 x^4 + 6 x^5), x = t / T.

    Its second derivative is continuous, its third is bounded but jumps at both ends, and its fourth has impulses there:
    it suits rigid feedforward; a trajectory refuses its fourth derivative.

    Args:
        distance: Distance L in the unit p of the path parameter, above 0.
        duration: Time T [s]; the shortest within the limits if None.
        limits: Limits of speed, acceleration and jerk [p/s, ...]; a finite snap limit cannot be met.

    Returns:
        The law from 0 to L.

    Raises:
        InputError: Neither duration nor limits, an argument out of range, or a duration too short for the limits.
    """
    if limits is not None and limits.snap != math.inf:
        raise InputError(
            f"the snap limit of the quintic time law is {limits.snap:g}, allowed is none because its jerk jumps at "
            "both ends; leave the snap out or choose ninth_degree or bang_bang_snap"
        )
    return _law(QUINTIC, "quintic", 3, distance, duration, limits)


def ninth_degree(distance: float, duration: float | None = None, limits: Limits | None = None) -> TimeLaw:
    """Return the 9th-degree time law s(t) = L (126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9), x = t / T.

    Four derivatives are continuous, as every feedforward requires (a polynomial of this degree: Swevers et al. 1991).

    Args:
        distance: Distance L in the unit p of the path parameter, above 0.
        duration: Time T [s]; the shortest within the limits if None.
        limits: Limits of speed, acceleration, jerk and snap [p/s, ...].

    Returns:
        The law from 0 to L.

    Raises:
        InputError: Neither duration nor limits, an argument out of range, or a duration too short for the limits.
    """
    return _law(NINTH_DEGREE, "ninth_degree", 5, distance, duration, limits)


@cache
def peaks(shape: tuple[float, ...]) -> tuple[float, float, float, float]:
    """Return the largest sizes of the first four derivatives of a polynomial on [0, 1].

    Args:
        shape: Coefficients in ascending powers.

    Returns:
        Peaks of the first to fourth derivative (for L = 1, T = 1).
    """
    polynomial = np.polynomial.Polynomial(shape)
    result = []
    for order in range(1, 5):
        roots = polynomial.deriv(order + 1).roots()
        inside = roots.real[(np.abs(roots.imag) < 1e-6) & (roots.real > 0.0) & (roots.real < 1.0)]
        result.append(float(np.max(np.abs(polynomial.deriv(order)(np.concatenate((inside, [0.0, 1.0])))))))
    return result[0], result[1], result[2], result[3]


def _law(
    shape: tuple[float, ...],
    name: str,
    bounded_derivatives: int,
    distance: float,
    duration: float | None,
    limits: Limits | None,
) -> TimeLaw:
    """Return the law of a polynomial shape that is point-symmetric about its middle."""
    way = positive(distance, "distance of the move", "(unit of the path)")
    durations = {
        limit_name: (peak * way / limit) ** (1.0 / order)
        for order, (limit_name, peak, limit) in enumerate(
            zip(LIMIT_NAMES, peaks(shape), (limits or Limits()).values, strict=True), start=1
        )
    }
    worst = max(durations, key=lambda key: durations[key])
    if duration is None and durations[worst] == 0.0:
        raise InputError(
            f"the {name} time law has neither duration nor limits, allowed is a duration in s or at least one limit; "
            "give one of them"
        )
    time = durations[worst] if duration is None else positive(duration, "duration", "s")
    if time < durations[worst] * (1.0 - 1e-9):
        raise InputError(
            f"the duration of the {name} time law is {time:g} s, allowed are at least {durations[worst]:.6g} s for the "
            f"{worst} limit; lengthen the duration or leave it out"
        )
    return _symmetric(np.array(shape), way, time, bounded_derivatives, name)


def _symmetric(shape: FloatArray, way: float, time: float, bounded_derivatives: int, name: str) -> TimeLaw:
    """Expand the first half about the start and the second about the end, so that both end values are exact."""
    powers = np.arange(shape.size)
    first = way * shape / time**powers
    second = -first * (-1.0) ** powers
    second[0] += way
    return TimeLaw(
        knots=np.array([0.0, 0.5 * time, time]),
        origins=np.array([0.0, time]),
        coefficients=np.array([first, second]),
        start=0.0,
        end=way,
        bounded_derivatives=bounded_derivatives,
        name=name,
    )
