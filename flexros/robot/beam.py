"""Assumed modes of a uniform beam, clamped at one end, with a mass at the other (Moberg 2007, section 3.2.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

SCAN = 0.01
"""Step of the search for roots of the frequency equation [1] (chosen)."""


@dataclass(frozen=True)
class ModeShape:
    """Eigenfunction of a beam that is clamped at xi = 0, with the largest deflection 1.

        phi(xi) = scale ((cosh(b xi) - cos(b xi)) - s (sinh(b xi) - sin(b xi))),   0 <= xi = x / l <= 1

    Attributes:
        root: b, root of the frequency equation [1].
        ratio: s, from the conditions at the free end [1].
        scale: Factor that makes the largest deflection 1.
    """

    root: float
    ratio: float
    scale: float

    @classmethod
    def of(cls, root: float, ratio: float) -> ModeShape:
        """Return the shape of a root, scaled."""
        grid = cls(root, ratio, 1.0).deflection(np.linspace(0.0, 1.0, 2001))
        return cls(root, ratio, 1.0 / float(grid[np.argmax(np.abs(grid))]))

    def deflection(self, xi: FloatArray) -> FloatArray:
        """Return phi [1] at positions xi [1]."""
        b = self.root * xi
        value: FloatArray = (np.cosh(b) - np.cos(b)) - self.ratio * (np.sinh(b) - np.sin(b))
        return self.scale * value

    def slope(self, xi: FloatArray) -> FloatArray:
        """Return d phi / d xi [1] at positions xi [1]."""
        b = self.root * xi
        value: FloatArray = (np.sinh(b) + np.sin(b)) - self.ratio * (np.cosh(b) - np.cos(b))
        return self.scale * self.root * value

    def curvature(self, xi: FloatArray) -> FloatArray:
        """Return d^2 phi / d xi^2 [1] at positions xi [1]."""
        b = self.root * xi
        value: FloatArray = (np.cosh(b) + np.cos(b)) - self.ratio * (np.sinh(b) + np.sin(b))
        return self.scale * self.root**2 * value


def clamped_modes(number: int, tip_mass: float = 0.0, tip_inertia: float = 0.0) -> tuple[ModeShape, ...]:
    """Compute the first modes of a clamped beam with a load at its tip.

    The frequency equation follows from phi''(1) = b^4 J phi'(1) and phi'''(1) = -b^4 m phi(1); without load it is
    cosh(b) cos(b) = -1, so b = 1.8751, 4.6941, 7.8548, ... (L. Meirovitch, Fundamentals of Vibrations, 2001, 8.4).

    Args:
        number: Number of modes.
        tip_mass: m, load over the mass of the beam [1].
        tip_inertia: J, inertia of the load over the mass of the beam times its length squared [1].

    Returns:
        The modes, lowest frequency first; the frequency is (b / l)^2 sqrt(E I l / mass).
    """
    from scipy.optimize import brentq  # loads slowly

    found: list[ModeShape] = []
    low = 0.05
    before = _frequency_equation(low, tip_mass, tip_inertia)
    while len(found) < number:
        high = low + SCAN
        value = _frequency_equation(high, tip_mass, tip_inertia)
        if before * value < 0.0:
            root = float(brentq(_frequency_equation, low, high, (tip_mass, tip_inertia), xtol=1e-14))
            found.append(ModeShape.of(root, _ratio(root, tip_inertia)))
        low, before = high, value
    return tuple(found)


def _ratio(b: float, inertia: float) -> float:
    C, S, c, s = np.cosh(b), np.sinh(b), np.cos(b), np.sin(b)
    return float(((C + c) - b**3 * inertia * (S + s)) / ((S + s) - b**3 * inertia * (C - c)))


def _frequency_equation(b: float, mass: float, inertia: float) -> float:
    """Return the determinant of both conditions at the tip, over cosh(b)^2 / b so that it stays of order one."""
    C, S, c, s = np.cosh(b), np.sinh(b), np.cos(b), np.sin(b)
    bending = (C + c) - b**3 * inertia * (S + s), (S + s) - b**3 * inertia * (C - c)
    shear = (S - s) + b * mass * (C - c), (C + c) + b * mass * (S - s)
    return float((bending[1] * shear[0] - bending[0] * shear[1]) / C)


def gauss_points(number: int) -> tuple[FloatArray, FloatArray]:
    """Return positions xi on [0, 1] and weights of Gauss-Legendre quadrature, each shape (number,)."""
    points, weights = np.polynomial.legendre.leggauss(number)
    return (points + 1.0) / 2.0, weights / 2.0
