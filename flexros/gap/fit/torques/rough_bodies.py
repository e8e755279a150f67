"""Bodies of a robot file that are off by far more than their tolerance."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.effects import PlacedEffect
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.errors import InputError
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.robot import Robot

CENTER = ("x", "y", "z")
"""Axes of a centre of mass."""


def is_inertial(name: str) -> bool:
    """Return whether a parameter is the mass, a part of the centre of mass or of the inertia of a body.

    Args:
        name: Name of the parameter, e.g. "body_2.center_of_mass.x".
    """
    body, _, number = name.partition(".")
    return body.startswith("body_") and number.partition(".")[0] in ("mass", "center_of_mass", "inertia")


def with_rough_bodies(tolerance: Tolerance, rough: float) -> Tolerance:
    """Return a tolerance in which the inertial numbers of bodies deviate by at least some share.

    Args:
        tolerance: The tolerance.
        rough: The share [1].
    """
    pairs = zip(tolerance.names, tolerance.deviations, strict=True)
    return replace(tolerance, deviations=tuple(max(deviation, rough * is_inertial(name)) for name, deviation in pairs))


def with_rough_inertias(tolerance: Tolerance, rough: float) -> Tolerance:
    """Return a tolerance in which the inertias of bodies about their centres of mass deviate by at least some share.

    Args:
        tolerance: The tolerance.
        rough: The share [1].
    """
    pairs = zip(tolerance.names, tolerance.deviations, strict=True)
    deviations = (max(deviation, rough * (is_inertial(name) and ".inertia." in name)) for name, deviation in pairs)
    return replace(tolerance, deviations=tuple(deviations))


def fitted_bodies(robot: Robot, factors: Mapping[str, float]) -> list[PlacedEffect]:
    """Return the differences of the bodies of a robot whose numbers are scaled by factors.

    Factors of the entries of an inertia are fitted one by one. Where no body can have such an inertia, it is that of
    the file times the factor of the mass.

    Args:
        robot: The robot.
        factors: Factors by name of the parameter [1].
    """
    found = []
    for number in range(1, len(robot.spec.bodies) + 1):
        body = f"body_{number}"
        changes = {
            name.rpartition(".")[2]: (factor - 1.0) * robot.parameters[name].value
            for name, factor in factors.items()
            if name.startswith(f"{body}.") and is_inertial(name)
        }
        difference = BodyDifference(**changes)
        try:
            difference.changed(robot, body)
        except InputError:
            heavier = factors.get(f"{body}.mass", 1.0) - 1.0
            scaled = {name: heavier * robot.parameters[f"{body}.inertia.{name}"].value for name in INERTIA_COMPONENTS}
            difference = difference.model_copy(update=scaled)
        if difference.values(robot, body):
            found.append(PlacedEffect(difference, body))
    return found
