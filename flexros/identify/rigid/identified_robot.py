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

_OF_ZERO = 0.02
"""Size at which a parameter that is nominally zero may change, relative to the largest of its kind (chosen)."""


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

    Base parameters are combinations, so many files give the identified torques: that with the smallest changes relative
    to the nominal values is taken. Its single numbers therefore rest on the nominal ones. A body or motor that would
    get what none can have, such as a negative inertia, is left as it is, which is said.

    Args:
        fit: The fit.

    Returns:
        Values with their relative standard deviations.
    """
    nominal = np.array([parameter.nominal for parameter in fit.base.standard])
    share = _smallest_change(fit)
    standard = nominal + share @ (fit.values - fit.base.nominal)
    values: dict[str, IdentifiedValue] = {}
    left_out: dict[str, str] = {}
    for owner in dict.fromkeys(parameter.name.split(".")[0] for parameter in fit.base.standard):
        found = _of_owner(fit, owner, standard, share)
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


def _smallest_change(fit: RigidFit) -> FloatArray:
    """Matrix from changes of base parameters to the smallest relative changes of parameters, shape (P, r)."""
    standard = fit.base.standard
    kinds = [parameter.name.split(".", 1)[1].split(".")[0] for parameter in standard]
    largest = {kind: max(abs(p.nominal) for p, k in zip(standard, kinds, strict=True) if k == kind) for kind in kinds}
    size = np.array([max(abs(p.nominal), _OF_ZERO * largest[k]) for p, k in zip(standard, kinds, strict=True)])
    alone = np.zeros(len(standard), bool)
    alone[list(fit.base.leading)] = True
    size[alone & (size == 0)] = 1.0  # friction of which the file knows nothing
    weighted = fit.base.combination * size
    return size[:, None] * np.linalg.pinv(weighted, rcond=1e-12)


def _of_owner(fit: RigidFit, owner: str, standard: FloatArray, share: FloatArray) -> dict[str, IdentifiedValue] | str:
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
            moved = standard + sign * 1e-3 * step * share[:, place]
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
    for entry in INERTIA_COMPONENTS:  # what no motion shows stays as it is about the centre, wherever that moves
        if f"{body}.inertia_at_joint.{entry}" in fit.base.without_effect:
            about_center[entry] = fit.robot.parameters[f"{body}.inertia.{entry}"].value
    found[f"{body}.mass"] = mass
    found.update({f"{body}.center_of_mass.{axis}": float(center[place]) for place, axis in enumerate("xyz")})
    found.update({f"{body}.inertia.{entry}": value for entry, value in about_center.items()})
    return found


def _motor_values(fit: RigidFit, motor: str, names: list[str], standard: FloatArray) -> dict[str, float]:
    """Rotor inertia and viscous friction, the mean of both directions where they were told apart."""
    own = {name: float(standard[names.index(name)]) for name in names if name.startswith(f"{motor}.")}
    viscous = [value for name, value in own.items() if ".viscous_friction" in name]
    return {f"{motor}.inertia": own[f"{motor}.inertia"], f"{motor}.viscous_friction": float(np.mean(viscous))}
