"""Bending of a link in the robot file: rigidity, and the assumed modes that follow from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from flexros.config.settings import Settings
from flexros.robot.beam import ModeShape, clamped_modes, gauss_points
from flexros.robot.quantity import Inertia, Mass, NotNegative, Positive, Quantity, check_unit

if TYPE_CHECKING:
    from flexros.robot.specification import BendingAxis, Body

MOST_MODES = 6
"""Largest number of modes of a link in one plane (chosen): beyond, a link of several bodies is the better model."""

INTEGRATION_POINTS = 48
"""Points of the integral of the squared curvature (chosen: exact to 1e-12 for `MOST_MODES`)."""


class BendingMode(Settings):
    """One assumed mode; its coordinate is the largest deflection of the link [m]."""

    root: float = Field(gt=0, description="root b of the frequency equation of the shape [1]")
    ratio: float = Field(description="ratio s of the shape [1]")
    stiffness: Positive = Field(description="modal stiffness [N/m]")
    damping: NotNegative = Field(description="modal damping [N s/m]")

    @property
    def shape(self) -> ModeShape:
        """The shape along the link."""
        return ModeShape.of(self.root, self.ratio)


class Bending(Settings):
    """Bending of a link about one axis, as a uniform beam clamped at its joint (Moberg 2007, equation 3.20).

    The load at the tip shapes the modes only; as masses the following bodies count, wherever they move.
    """

    rigidity: Positive = Field(description="bending stiffness E I [N m2]")
    modes: Annotated[int, Field(ge=1, le=MOST_MODES)] | tuple[BendingMode, ...] = Field(
        2, description="number of assumed modes, 1 to 6; or the modes themselves"
    )
    damping_ratio: float = Field(0.0, ge=0, description="damping ratio of each mode [1]")
    tip_mass: Mass = Field(
        default_factory=lambda: Quantity(value=0.0, unit="kg"), description="load that shapes the modes [kg]"
    )
    tip_inertia: Inertia = Field(
        default_factory=lambda: Quantity(value=0.0, unit="kg m2"), description="its inertia that does so [kg m2]"
    )

    def listed(self) -> tuple[BendingMode, ...]:
        """The modes; the number of them is replaced by `with_modes` when the file is read."""
        assert not isinstance(self.modes, int)
        return self.modes

    def with_modes(self, mass: float, length: float) -> Bending:
        """Return the same with the modes computed, if only their number is given.

        With phi_j(x) the shapes, the modal stiffness is E I times the integral of phi_j''^2 over the link, the modal
        damping 2 ratio sqrt(stiffness times modal mass with load).

        Args:
            mass: Mass of the link [kg].
            length: Its length [m].
        """
        if not isinstance(self.modes, int):
            return self
        load, inertia = self.tip_mass.value, self.tip_inertia.value
        xi, weights = gauss_points(INTEGRATION_POINTS)
        modes = []
        for shape in clamped_modes(self.modes, load / mass, inertia / (mass * length**2)):
            stiffness = self.rigidity.value / length**3 * float(weights @ shape.curvature(xi) ** 2)
            tip = np.ones(1)
            modal_mass = mass * float(weights @ shape.deflection(xi) ** 2)
            modal_mass += load * float(shape.deflection(tip)[0]) ** 2
            modal_mass += inertia * (float(shape.slope(tip)[0]) / length) ** 2
            damping = 2.0 * self.damping_ratio * float(np.sqrt(stiffness * modal_mass))
            own: dict[str, Any] = {"source": self.rigidity.source, "tolerance": self.rigidity.tolerance}
            modes.append(
                BendingMode(
                    root=shape.root,
                    ratio=shape.ratio,
                    stiffness=Quantity(value=stiffness, unit="N/m", **own),
                    damping=Quantity(value=damping, unit="N s/m", **own),
                )
            )
        return self.model_copy(update={"modes": tuple(modes)})


def checked_bending(body: Body) -> dict[BendingAxis, Bending]:
    """Check the bending of a body and compute its modes.

    Raises:
        ValueError: The body is no straight uniform beam along one of its axes, or does not move.
    """
    length = np.array(body.length.value)
    along = np.flatnonzero(length)
    if along.size != 1:
        raise ValueError(
            f"has bending, but its length is {length.tolist()}; a link that bends is straight along one of its axes: "
            "give one component of length"
        )
    axis = int(along[0])
    if not any(direction.motor or direction.spring != "rigid" for direction in body.directions.values()):
        raise ValueError("has bending, but does not move; a link that bends is clamped to a joint: give it a direction")
    if body.mass.value <= 0:
        raise ValueError(f"has bending, but mass {body.mass.value:g} kg; give the mass of the beam")
    _check_uniform(body, axis)
    result: dict[BendingAxis, Bending] = {}
    for name, bending in body.bending.items():
        check_unit(bending.rigidity, "N m2", f"bending.{name}.rigidity")
        if "xyz".index(name[1]) == axis:
            raise ValueError(f"has bending about {name}, its own long axis; allowed are the two axes across it")
        result[name] = bending.with_modes(body.mass.value, abs(float(length[axis])))
    return result


def _check_uniform(body: Body, axis: int) -> None:
    """Refuse a centre of mass or inertia that contradict a uniform beam."""
    middle, given = np.array(body.length.value) / 2.0, np.array(body.center_of_mass.value)
    if np.any(given) and not np.allclose(given, middle, rtol=1e-6):
        raise ValueError(
            f"has bending and center_of_mass {given.tolist()}, but a uniform beam has it at {middle.tolist()}; "
            "leave it out, and give additional masses as bodies of their own"
        )
    tensor = body.inertia.matrix()
    tensor[axis, axis] = 0.0
    if np.any(tensor):
        raise ValueError(
            f"has bending and an inertia across {'xyz'[axis]}, which follows from mass and length of a uniform beam; "
            f"give at most inertia.{'xyz'[axis] * 2}, about the beam"
        )
