"""Parameters of the nominal model that are known with a tolerance only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.errors import unknown_name
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot

KINDS = {
    "stiffness": (".stiffness",),
    "damping": (".damping", ".viscous_friction"),
    "inertia": (".inertia", ".mass", ".inertia.xx", ".inertia.yy", ".inertia.zz"),
}
"""Kinds of robot parameters by the endings of their names."""


@dataclass(frozen=True)
class Tolerance:
    """Tolerated parameters.

    Attributes:
        names: Names of robot parameters.
        deviations: Standard deviation of the logarithm of each [1].
    """

    names: tuple[str, ...] = ()
    deviations: tuple[float, ...] = ()


def tolerance_of(robot: Robot, given: Mapping[str, float]) -> Tolerance:
    """Collect the tolerances of a robot: of all parameters that are neither zero nor exact.

    Args:
        robot: The nominal robot; its file states a tolerance per parameter.
        given: Relative tolerances by kind (stiffness, damping, inertia) that replace those of the file [1].

    Raises:
        InputError: A kind is unknown.
    """
    for kind in given:
        if kind not in KINDS:
            raise unknown_name("kind of tolerance", kind, KINDS)
    tolerances: dict[str, float] = {}
    for name, parameter in robot.parameters.items():
        if f".{SERVO}" in name and robot.commands == "torque":
            continue  # the servos have no part in it
        deviation = parameter.tolerance
        for kind, endings in KINDS.items():
            if kind in given and name.endswith(endings):
                deviation = given[kind]
        if deviation > 0 and parameter.value != 0:
            tolerances[name] = deviation
    return Tolerance(tuple(tolerances), tuple(tolerances.values()))
