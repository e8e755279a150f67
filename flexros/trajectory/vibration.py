"""Path of a sum of cosines about a point, faded in and out."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath
from flexros.trajectory.polynomial import NINTH_DEGREE
from flexros.trajectory.time_law import TimeLaw

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_ROWS_AT_ONCE = 100_000
"""Times that are evaluated at once (chosen): each cosine of each joint is a temporary number."""


@dataclass(frozen=True, eq=False)
class Vibration(AbstractPath):
    """P(t) = centre + w(t) sum_k A_k cos(2 pi f_k t + phi_k), with the time t as path parameter.

    The window w rises from 0 to 1 within the fade time by the polynomial of 9th degree and falls likewise before the
    end, so that the motion starts and ends at rest in the centre. Between the fades the window is 1.

    Args:
        centre: Joint positions about which it moves [rad or m], shape (n_joints,).
        frequency: Frequencies [Hz], shape (F,).
        amplitude: Amplitudes A [rad or m], shape (n_joints, F).
        phase: Phases phi [rad], shape (n_joints, F).
        duration: Time from begin to end, at least twice the fade [s].
        fade: Time in which it is faded in, and out [s].
    """

    centre: FloatArray
    frequency: FloatArray
    amplitude: FloatArray
    phase: FloatArray
    duration: float
    fade: float
    parameter_unit = "s"

    @property
    def extent(self) -> float:
        """The duration [s]."""
        return self.duration

    @property
    def n_out(self) -> int:
        """Number of joints."""
        return self.centre.size

    @property
    def pace(self) -> float:
        """Bound of the speed of all joints together [rad/s or m/s]."""
        return float(np.linalg.norm(self.coordinate_pace))

    @property
    def coordinate_pace(self) -> FloatArray:
        """Bound of the speed of every joint: all cosines at their peak during a fade, shape (n_joints,)."""
        steepest = float(np.polynomial.Polynomial(NINTH_DEGREE).deriv()(0.5)) / self.fade
        size = np.abs(self.amplitude)
        pace: FloatArray = size @ (2.0 * np.pi * self.frequency) + steepest * np.sum(size, axis=1)
        return pace

    def law(self) -> TimeLaw:
        """Return the time law with the time as path parameter."""
        return TimeLaw(
            knots=np.array([0.0, self.duration]),
            origins=np.zeros(1),
            coefficients=np.array([[0.0, 1.0]]),
            start=0.0,
            end=self.duration,
            bounded_derivatives=MAX_DERIVATIVES,
            name="vibration",
        )

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`; window and sum by the product rule."""
        s = np.asarray(s, dtype=float)
        result = np.empty((order + 1, s.size, self.n_out))
        for first in range(0, s.size, _ROWS_AT_ONCE):
            rows = slice(first, first + _ROWS_AT_ONCE)
            window, harmonics = self._window(s[rows], order), self._harmonics(s[rows], order)
            for k in range(order + 1):
                result[k, rows] = sum(comb(k, i) * window[i][:, None] * harmonics[k - i] for i in range(k + 1))
        result[0] += self.centre
        return result

    def _window(self, s: FloatArray, order: int) -> FloatArray:
        """Compute the window and its derivatives, shape (order + 1, n)."""
        result = np.zeros((order + 1, s.size))
        result[0] = 1.0
        shape = np.polynomial.Polynomial(NINTH_DEGREE)
        for sign, where in ((1.0, s), (-1.0, self.duration - s)):
            inside = where < self.fade
            x = where[inside] / self.fade
            for k in range(order + 1):
                result[k, inside] = (sign / self.fade) ** k * shape.deriv(k)(x) if k else shape(x)
        return result

    def _harmonics(self, s: FloatArray, order: int) -> FloatArray:
        """Compute the sum of cosines and its derivatives, shape (order + 1, n, n_joints)."""
        w = 2.0 * np.pi * self.frequency
        turned = np.exp(1j * s[:, None] * w)
        size = self.amplitude * np.exp(1j * self.phase)
        return np.array([(turned @ (size * (1j * w) ** k).T).real for k in range(order + 1)])
