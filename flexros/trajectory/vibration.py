"""A sum of cosines about a point, faded in and out."""

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


@dataclass(frozen=True, eq=False)
class Vibration(AbstractPath):
    """P(t) = centre + w(t) sum_k A_k cos(2 pi f_k t + phi_k), the path parameter being the time t.

    The window w rises within the fade time from 0 to 1 by the polynomial of 9th degree and falls likewise before the
    end, so that the motion begins and ends at rest in the centre; between the fades it is exactly that of the lines.

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
        """Bound of the speed of every joint: all lines at their peak, within a fade, shape (n_joints,)."""
        steepest = float(np.polynomial.Polynomial(NINTH_DEGREE).deriv()(0.5)) / self.fade
        size = np.abs(self.amplitude)
        pace: FloatArray = size @ (2.0 * np.pi * self.frequency) + steepest * np.sum(size, axis=1)
        return pace

    def law(self) -> TimeLaw:
        """Return the law by which the path parameter is the time."""
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
        """See `AbstractPath.derivatives`; the window and the sum by the rule of the product."""
        s = np.asarray(s, dtype=float)
        window, wave = self._window(s, order), self._wave(s, order)
        result = np.empty((order + 1, s.size, self.n_out))
        for k in range(order + 1):
            result[k] = sum(comb(k, i) * window[i][:, None] * wave[k - i] for i in range(k + 1))
        result[0] += self.centre
        return result

    def _window(self, s: FloatArray, order: int) -> FloatArray:
        """Window and derivatives, shape (order + 1, n)."""
        result = np.zeros((order + 1, s.size))
        result[0] = 1.0
        shape = np.polynomial.Polynomial(NINTH_DEGREE)
        for sign, where in ((1.0, s), (-1.0, self.duration - s)):
            inside = where < self.fade
            x = where[inside] / self.fade
            for k in range(order + 1):
                result[k, inside] = (sign / self.fade) ** k * shape.deriv(k)(x) if k else shape(x)
        return result

    def _wave(self, s: FloatArray, order: int) -> FloatArray:
        """Sum of the lines and its derivatives, shape (order + 1, n, n_joints)."""
        w = 2.0 * np.pi * self.frequency
        turned = np.exp(1j * s[:, None] * w)
        size = self.amplitude * np.exp(1j * self.phase)
        return np.array([(turned @ (size * (1j * w) ** k).T).real for k in range(order + 1)])
