"""Mass, centre and inertia of a body in some frame: moved to another one, joined with those of another body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.exchange.numbers import Written
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.specification import Body

ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Names of the entries of an inertia, and their places in the tensor."""


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

    @classmethod
    def of(cls, body: Body) -> BodyInertia:
        """Return those of a body of a robot file, in its own frame."""
        return cls(body.mass.value, np.array(body.center_of_mass.value), body.straight_inertia())

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

    def written(self, body: str, mass: str, center: str, inertia: str) -> list[Written]:
        """List those that are not zero, in a new file.

        Args:
            body: Name of the body.
            mass: Place of its mass in the file.
            center: Place of its centre of mass.
            inertia: Place of its inertia.
        """
        rows = [("mass", mass, self.mass, "kg")]
        rows += [(f"centre of mass {axis}", center, float(self.center[k]), "m") for k, axis in enumerate("xyz")]
        rows += [(f"inertia {entry}", inertia, float(self.inertia[at]), "kg m2") for entry, at in ENTRIES.items()]
        return [Written(body, quantity, place, None, value, unit) for quantity, place, value, unit in rows if value]


def point_mass(mass: float, place: FloatArray) -> BodyInertia:
    """Return the numbers of a point mass [kg] at a place [m], shape (3,)."""
    return BodyInertia(mass, place, np.zeros((3, 3)))
