"""Mass, centre and inertia of a body in some frame: moved to another one, joined with those of another body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class BodyInertia:
    """Mass, centre and inertia in the frame of a body.

    Attributes:
        mass: Mass [kg].
        center: Centre of mass [m], shape (3,).
        inertia: Inertia about it [kg m2], shape (3, 3).
    """

    mass: float
    center: FloatArray
    inertia: FloatArray

    @property
    def possible(self) -> bool:
        """Whether a body can have them: positive, and no moment above the sum of the others."""
        moments = np.linalg.eigvalsh(self.inertia)
        return bool(self.mass > 0 and moments[0] > 0 and moments[2] <= (1 + 1e-9) * (moments[0] + moments[1]))

    def moved(self, turn: FloatArray, place: FloatArray) -> BodyInertia:
        """Return them in another frame.

        Args:
            turn: Rotation from this frame to the other one, shape (3, 3).
            place: Origin of this frame in the other one [m], shape (3,).
        """
        return BodyInertia(self.mass, place + turn @ self.center, turn @ self.inertia @ turn.T)

    def plus(self, other: BodyInertia, sign: int = 1) -> BodyInertia:
        """Return those of both bodies, or without the other one (sign -1), in their common frame."""
        mass = self.mass + sign * other.mass
        center = (self.mass * self.center + sign * other.mass * other.center) / mass if mass else self.center
        own, others = self.center - center, other.center - center
        inertia = self.inertia + sign * other.inertia
        inertia = inertia + point_inertia(self.mass, own) + point_inertia(sign * other.mass, others)
        return BodyInertia(mass, center, inertia)


def point_mass(mass: float, place: FloatArray) -> BodyInertia:
    """Return the numbers of a point mass [kg] at a place [m], shape (3,)."""
    return BodyInertia(mass, place, np.zeros((3, 3)))
