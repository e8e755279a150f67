"""Time law that is bang-bang in the fourth derivative (snap), within limits on all four."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.limits import LIMIT_NAMES, Limits
from flexros.trajectory.time_law import TimeLaw, positive

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

PATTERN = (1, 0, -1, 0, -1, 0, 1)
"""Sign of the snap during acceleration, in phases of lengths snap, jerk, snap, acceleration, snap, jerk, snap time."""


@dataclass(frozen=True)
class SnapProfile:
    """Phase lengths of the symmetric profile (Lambrechts, Boerlage and Steinbuch 2005, section 3).

    Args:
        snap: Size D of the snap [p/s^4].
        snap_time: Length of every snap pulse [s].
        jerk_time: Length of every phase of constant jerk [s].
        acceleration_time: Length of either phase of constant acceleration [s].
        cruise_time: Length of the phase of constant speed [s].
    """

    snap: float
    snap_time: float
    jerk_time: float
    acceleration_time: float
    cruise_time: float

    @property
    def duration(self) -> float:
        """Length of the whole motion [s]."""
        return 8.0 * self.snap_time + 4.0 * self.jerk_time + 2.0 * self.acceleration_time + self.cruise_time


def snap_profile(distance: float, limits: Limits) -> SnapProfile:
    """Compute the fastest symmetric profile of a distance within limits.

    With x = snap time, y = x + jerk time, z = x + y + acceleration time and w = x + y + z + cruise time the profile
    reaches jerk D x, acceleration D x y, speed D x y z and distance D x y z w in the time x + y + z + w, with
    x <= y, x + y <= z and x + y + z <= w. It is fastest to maximise x, then y, then z within distance and limits.
    (Moves too short for a cruise phase would be up to 7 % faster without the return to zero jerk at the peak speed; the
    profile keeps the cruise pattern, as the reference does.)

    Args:
        distance: Distance in the unit p of the path parameter, above 0.
        limits: Finite snap limit; the others may be infinite [p/s, p/s^2, p/s^3, p/s^4].

    Returns:
        The phase lengths, with the snap (at most its limit) that meets the distance exactly.

    Raises:
        InputError: The distance is not above 0, or the snap limit is infinite.
    """
    length = positive(distance, "distance of the move", "(unit of the path)")
    if limits.snap == math.inf:
        raise InputError(
            "the bang-bang time law has no snap limit, allowed is a finite limit above 0 for the derivative of the "
            "jerk; give the snap"
        )
    speed, acceleration, jerk, snap = limits.values
    c_length, c_speed, c_acceleration, c_jerk = length / snap, speed / snap, acceleration / snap, jerk / snap
    x = min((c_length / 8.0) ** 0.25, (c_speed / 2.0) ** (1.0 / 3.0), math.sqrt(c_acceleration), c_jerk)
    y = max(x, min(_middle(x, c_length), _outer(x, c_speed / x), c_acceleration / x))
    y = _snapped(y, x)
    z = max(x + y, min(_outer(x + y, c_length / (x * y)), c_speed / (x * y)))
    z = _snapped(z, x + y)
    w = _snapped(max(x + y + z, c_length / (x * y * z)), x + y + z)
    return SnapProfile(length / (x * y * z * w), x, y - x, z - (x + y), w - (x + y + z))


def bang_bang_snap(distance: float, limits: Limits) -> TimeLaw:
    """Return the time law that is bang-bang in the snap: +D, -D, -D, +D | cruise | mirrored.

    Phases of constant jerk, acceleration and speed are inserted where limits are reached. The third derivative is
    continuous, the fourth bounded, as every feedforward requires. The pieces are exact polynomials of 4th degree.

    Args:
        distance: Distance in the unit p of the path parameter, above 0.
        limits: Limits [p/s, p/s^2, p/s^3, p/s^4], the snap finite.

    Returns:
        The law from 0 to the distance.

    Raises:
        InputError: An argument is out of range.
    """
    profile = snap_profile(distance, limits)
    x, jerk_time = profile.snap_time, profile.jerk_time
    lengths = (x, jerk_time, x, profile.acceleration_time, x, jerk_time, x)
    times, rows, state = [0.0], [], np.zeros(4)
    for sign, length in zip(PATTERN, lengths, strict=True):
        if length > 0.0:
            rows.append(np.append(state, sign * profile.snap) / (1.0, 1.0, 2.0, 6.0, 24.0))
            state = _advanced(rows[-1], length)
            times.append(times[-1] + length)
    duration = profile.duration
    cruise = [np.array([state[0], state[1], 0.0, 0.0, 0.0])] if profile.cruise_time > 0.0 else []
    signs = np.array([-1.0, 1.0, -1.0, 1.0, -1.0])
    mirrored = [row * signs + (distance, 0.0, 0.0, 0.0, 0.0) for row in reversed(rows)]
    starts = times[:-1]
    back = [duration - time for time in reversed(times)]
    return TimeLaw(
        knots=np.array([*starts, *([times[-1]] if cruise else []), *back]),
        origins=np.array([*starts, *([times[-1]] if cruise else []), *[duration - t for t in reversed(starts)]]),
        coefficients=np.array([*rows, *cruise, *mirrored]),
        start=0.0,
        end=float(distance),
        bounded_derivatives=4,
        name="bang_bang_snap",
    )


def reached(profile: SnapProfile) -> Limits:
    """Return the largest speed, acceleration, jerk and snap of a profile [p/s, ...]."""
    x = profile.snap_time
    y = x + profile.jerk_time
    z = x + y + profile.acceleration_time
    d = profile.snap
    return Limits(**dict(zip(LIMIT_NAMES, (d * x * y * z, d * x * y, d * x, d), strict=True)))


def _middle(x: float, c_length: float) -> float:
    """Solve 2 x y (x + y)^2 = c_length for y by Newton's method from above, where the convergence is monotone."""
    target = c_length / (2.0 * x)
    y = float(np.cbrt(target))
    for _ in range(60):
        value = y * (x + y) ** 2 - target
        step = value / ((x + y) * (x + 3.0 * y))
        y -= step
        if abs(step) <= 1e-16 * y:
            break
    return y


def _outer(sum_xy: float, target: float) -> float:
    """Solve z (sum_xy + z) = target for z > 0 without cancellation."""
    if target == math.inf:
        return math.inf
    return 2.0 * target / (sum_xy + math.hypot(sum_xy, 2.0 * math.sqrt(target)))


def _snapped(value: float, least: float) -> float:
    """Return the least length if a length exceeds it by rounding only, so that there is no phase of 1e-18 s."""
    return least if value - least <= 1e-12 * least else value


def _advanced(row: FloatArray, length: float) -> FloatArray:
    """Return position, speed, acceleration and jerk at the end of a polynomial piece, shape (4,)."""
    polynomial = np.polynomial.Polynomial(row)
    return np.array([(polynomial.deriv(k) if k else polynomial)(length) for k in range(4)])
