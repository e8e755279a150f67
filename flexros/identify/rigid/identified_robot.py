"""The robot file with what the rigid regression tells about its parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.standard_parameters import inertia_at_joint
from flexros.identify.robot_file import IdentifiedValue, identified_file
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.identify.rigid.fit import RigidFit

_LEAST_EFFECT = 1e-9
"""Relative change of a parameter below which the regression says nothing about it (chosen: round-off)."""


@dataclass(frozen=True, eq=False)
class IdentifiedRobot:
    """Parameters of the robot file that follow from a rigid fit.

    Attributes:
        values: New value and relative standard deviation by parameter name.
        left_out: Why parameters of a body or motor were left at their nominal values, by name of the body or motor.
    """

    values: Mapping[str, IdentifiedValue]
    left_out: Mapping[str, str]


def identified_values(fit: RigidFit) -> IdentifiedRobot:
    """Bring base parameters back to parameters of the robot file.

    A base parameter is a combination; all of its deviation is put down to the parameter that it is named after, the
    others keep their nominal values. So the new file gives the identified torques, though its single numbers rest on
    the nominal ones. What no body can have, such as a negative inertia, is left out and said.

    Args:
        fit: The fit.

    Returns:
        Values with their relative standard deviations.
    """
    nominal = np.array([parameter.nominal for parameter in fit.base.standard])
    lead = list(fit.base.leading)
    standard = nominal.copy()
    standard[lead] += fit.values - fit.base.nominal
    values: dict[str, IdentifiedValue] = {}
    left_out: dict[str, str] = {}
    for owner in dict.fromkeys(parameter.name.split(".")[0] for parameter in fit.base.standard):
        found = _of_owner(fit, owner, standard)
        if isinstance(found, str):
            left_out[owner] = found
        elif found:
            numbers = {name: entry.value for name, entry in found.items()}
            try:
                fit.robot.with_values(numbers, "the regression")
            except InputError as error:
                left_out[owner] = str(error)
            else:
                values.update(found)
    return IdentifiedRobot(values, left_out)


def identified_yaml(fit: RigidFit, identified: IdentifiedRobot) -> str:
    """Write the robot file with the identified values, their source and their tolerances.

    Args:
        fit: The fit.
        identified: What goes into the file.

    Returns:
        Text of the file.
    """
    source = f"identified by FlexROS, rigid regression of {fit.error.label}"
    return identified_file(fit.robot, identified.values, source)


def _of_owner(fit: RigidFit, owner: str, standard: FloatArray) -> dict[str, IdentifiedValue] | str:
    """Parameters of one body or motor that depend on what was estimated, or why there are none."""
    names = [parameter.name for parameter in fit.base.standard]
    evaluate = _body_values if owner.startswith("body") else _motor_values
    try:
        value = evaluate(fit, owner, names, standard)
    except ZeroDivisionError:
        return "its mass is zero, so its first moment gives no centre of mass"
    scale = {name: abs(number) for name, number in value.items()}
    variance = dict.fromkeys(value, 0.0)
    slopes = np.zeros((len(value), len(fit.values)))
    for place in fit.excitation.shown:
        step = max(fit.deviation[place], 1e-9 * abs(fit.values[place]), np.finfo(float).tiny)
        sides = []
        for sign in (1, -1):
            moved = standard.copy()
            moved[fit.base.leading[place]] += sign * 1e-3 * step
            sides.append(np.array(list(evaluate(fit, owner, names, moved).values())))
        slopes[:, place] = (sides[0] - sides[1]) / (2e-3 * step)
    reach = np.abs(slopes) * fit.deviation
    variance = dict(zip(value, np.einsum("ij,jk,ik->i", slopes, fit.covariance, slopes), strict=True))
    told = {
        name for name, row in zip(value, reach, strict=True) if row.max() > _LEAST_EFFECT * max(scale[name], 1e-300)
    }
    return {
        name: IdentifiedValue(number, float(np.sqrt(max(variance[name], 0.0))) / max(scale[name], 1e-300))
        for name, number in value.items()
        if name in told
    }


def _body_values(fit: RigidFit, body: str, names: list[str], standard: FloatArray) -> dict[str, float]:
    """Mass, centre of mass and inertia about it from the parameters at the joint."""
    own = {name: float(standard[names.index(name)]) for name in names if name.startswith(f"{body}.")}
    found = {}
    if f"{body}.viscous_friction" in own:
        found[f"{body}.viscous_friction"] = own[f"{body}.viscous_friction"]
    mass = own[f"{body}.mass"]
    moment = np.array([own[f"{body}.first_moment.{axis}"] for axis in "xyz"])
    if mass == 0 and not np.any(moment):
        center = moment
    elif mass == 0:
        raise ZeroDivisionError
    else:
        center = moment / mass
    at_joint = {entry: own[f"{body}.inertia_at_joint.{entry}"] for entry in INERTIA_COMPONENTS}
    about_center = inertia_at_joint(at_joint, mass, center, sign=-1.0)
    found[f"{body}.mass"] = mass
    found.update({f"{body}.center_of_mass.{axis}": float(center[place]) for place, axis in enumerate("xyz")})
    found.update({f"{body}.inertia.{entry}": value for entry, value in about_center.items()})
    return found


def _motor_values(fit: RigidFit, motor: str, names: list[str], standard: FloatArray) -> dict[str, float]:
    """Rotor inertia and viscous friction, the mean of both directions where they were told apart."""
    own = {name: float(standard[names.index(name)]) for name in names if name.startswith(f"{motor}.")}
    viscous = [value for name, value in own.items() if ".viscous_friction" in name]
    return {f"{motor}.inertia": own[f"{motor}.inertia"], f"{motor}.viscous_friction": float(np.mean(viscous))}
