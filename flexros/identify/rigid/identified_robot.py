"""The robot file with what the rigid regression tells about its parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.prior import prior_factor
from flexros.identify.rigid.standard_parameters import inertia_at_joint
from flexros.identify.robot_file import IdentifiedValue, identified_file
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from flexros.arrays import FloatArray
    from flexros.identify.rigid.fit import RigidFit

_LEAST_EFFECT = 1e-9
"""Relative change of a parameter below which the regression says nothing about it (chosen: round-off)."""

_MISSED = 1e-3
"""Relative difference from which a base parameter counts as not met, where its deviation is smaller (chosen)."""

_INERTIAL = ("inertia_at_joint", "first_moment", "mass")
"""Kinds of parameters that a body can only have together."""


@dataclass(frozen=True, eq=False)
class IdentifiedRobot:
    """Parameters of the robot file that follow from a rigid fit.

    Attributes:
        values: New value and relative standard deviation by parameter name.
        left_out: Why parameters were left at their nominal values, by name of the body, or of the parameter where
            that stands for itself.
        not_met: Base parameters that the file gives another value than was identified, since what was left out is
            missing: that value by name.
        base_values: Values of all base parameters in the file, shape (r,); of what a file has no place for, such as
            Coulomb friction, those that were identified.
    """

    values: Mapping[str, IdentifiedValue]
    left_out: Mapping[str, str]
    not_met: Mapping[str, float]
    base_values: FloatArray


def identified_values(fit: RigidFit) -> IdentifiedRobot:
    """Bring base parameters back to parameters of the robot file.

    Base parameters are combinations, so many files give the identified torques: the most likely one is taken, by the
    tolerances of the nominal values (`prior_factor`). Its single numbers therefore rest on the nominal ones, and their
    deviations are those of the regression and, in the directions that it does not tell, of the nominal values.
    What would be impossible, such as a body of negative inertia, is left as it is, and the others changed instead.

    Args:
        fit: The fit.

    Returns:
        Values with their relative standard deviations.
    """
    left_out: dict[str, str] = {}
    while True:
        share = _most_likely_change(fit, left_out)
        values, refused = _values(fit, share, left_out)
        if not refused:
            got = _base_values(fit, share)
            return IdentifiedRobot(values, left_out, _not_met(fit, got), got)
        left_out.update(refused)


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


def _most_likely_change(fit: RigidFit, left_out: Collection[str]) -> FloatArray:
    """Matrix from changes of the k base parameters that are shown to the most likely changes, shape (P, k).

    Base parameters for which too few parameters are left come as near as they can, in units of their likely changes.
    """
    factor = prior_factor(fit.robot, fit.base)
    factor[~np.any(fit.base.combination != 0, axis=0)] = 0.0  # no motion shows these
    seen = _seen(fit)
    unit = np.linalg.norm(seen @ factor, axis=1)
    factor[[_group(parameter.name) in left_out for parameter in fit.base.standard]] = 0.0
    share: FloatArray = factor @ np.linalg.pinv(seen @ factor / unit[:, None], rcond=1e-12) / unit
    return share


def _seen(fit: RigidFit) -> FloatArray:
    """Combinations of parameters that the regression takes for base parameters, shape (k, P)."""
    shown, hidden = list(fit.excitation.shown), list(fit.hidden)
    seen: FloatArray = fit.base.combination[shown] + fit.leakage @ fit.base.combination[hidden]
    return seen


def _change(fit: RigidFit, share: FloatArray) -> FloatArray:
    """Changes of the parameters, shape (P,)."""
    shown = list(fit.excitation.shown)
    change: FloatArray = share @ (fit.values - fit.base.nominal)[shown]
    return change


def _covariance(fit: RigidFit, share: FloatArray) -> FloatArray:
    """Covariance of all parameters, shape (P, P): what the regression leaves open is as uncertain as before it."""
    shown = list(fit.excitation.shown)
    left_open = (np.eye(len(share)) - share @ _seen(fit)) @ prior_factor(fit.robot, fit.base)
    covariance: FloatArray = share @ fit.covariance[np.ix_(shown, shown)] @ share.T + left_open @ left_open.T
    return covariance


def _values(
    fit: RigidFit, share: FloatArray, left_out: Collection[str]
) -> tuple[dict[str, IdentifiedValue], dict[str, str]]:
    """Numbers of the robot file that depend on what was estimated, and why others are impossible."""
    change, covariance = _change(fit, share), _covariance(fit, share)
    values: dict[str, IdentifiedValue] = {}
    refused: dict[str, str] = {}
    groups: dict[str, list[int]] = {}
    for place, parameter in enumerate(fit.base.standard):
        groups.setdefault(_group(parameter.name), []).append(place)
    for group, places in groups.items():
        if group in left_out:
            continue
        try:
            found = _of_group(fit, group, places, change, covariance, share)
            fit.robot.with_values({name: entry.value for name, entry in found.items()}, "the regression")
        except ZeroDivisionError:
            refused[group] = "its mass is zero, so its first moment gives no centre of mass"
        except InputError as error:
            refused[group] = str(error)
        else:
            values.update(found)
    return values, refused


def _of_group(
    fit: RigidFit, group: str, places: list[int], change: FloatArray, covariance: FloatArray, share: FloatArray
) -> dict[str, IdentifiedValue]:
    """Numbers that follow from the parameters at some places, those alone that depend on what was estimated."""
    names = [fit.base.standard[place].name for place in places]
    own = np.array([fit.base.standard[place].nominal for place in places]) + change[places]
    value = _numbers(fit, group, names, own)
    slopes = np.zeros((len(value), len(places)))
    block = covariance[np.ix_(places, places)]
    largest = float(np.max(np.abs(own))) or 1.0
    for place, step in enumerate(1e-5 * np.maximum(np.abs(own), 1e-3 * largest)):
        if block[place, place] > 0:
            side = np.zeros(len(own))
            side[place] = step
            above, below = (list(_numbers(fit, group, names, own + s).values()) for s in (side, -side))
            slopes[:, place] = (np.array(above) - np.array(below)) / (2 * step)
    variance = np.einsum("ij,jk,ik->i", slopes, block, slopes)
    deviation = np.sqrt(np.maximum(variance, 0.0))
    shown = list(fit.excitation.shown)
    reach = np.max(np.abs(slopes @ share[places]) * fit.deviation[shown], axis=1, initial=0.0)
    return {
        name: IdentifiedValue(number, float(spread) / max(abs(number), 1e-300))
        for (name, number), spread, effect in zip(value.items(), deviation, reach, strict=True)
        if effect > _LEAST_EFFECT * max(abs(number), 1e-300)
    }


def _base_values(fit: RigidFit, share: FloatArray) -> FloatArray:
    """Values of the base parameters in the file, shape (r,); as identified where a file has no place for them."""
    got = fit.base.nominal.copy()
    got[list(fit.excitation.shown)] += _seen(fit) @ _change(fit, share)
    groups = [_group(name) for name in fit.base.names]
    outside = ["." in group and group not in fit.robot.parameters for group in groups]
    return np.where(outside, fit.values, got)


def _not_met(fit: RigidFit, got: FloatArray) -> dict[str, float]:
    """Values in the file of base parameters that it misses by more than their deviation, the worst first."""
    missed = np.zeros(len(fit.values), bool)
    shown = list(fit.excitation.shown)
    size = np.maximum(np.maximum(np.abs(fit.values), np.abs(fit.base.nominal)), 1e-300)
    distance = np.abs(got - fit.values)
    missed[shown] = (distance > np.maximum(fit.deviation, _MISSED * size))[shown]
    places = sorted(np.flatnonzero(missed), key=lambda place: -distance[place] / size[place])
    return {fit.base.names[place]: float(got[place]) for place in places}


def _group(name: str) -> str:
    """Name of what is possible or impossible as a whole: a body's inertial parameters, else a number of its own."""
    owner, _, kind = name.partition(".")
    if owner.startswith("body") and kind.split(".")[0] in _INERTIAL:
        return owner
    return f"{owner}.viscous_friction" if kind.startswith("viscous_friction") else name


def _numbers(fit: RigidFit, group: str, names: list[str], own: FloatArray) -> dict[str, float]:
    """Numbers of the robot file from the parameters of a group; friction is the mean of both directions."""
    if "." in group:
        return {group: float(np.mean(own))} if group in fit.robot.parameters else {}
    return _of_body(fit, group, dict(zip(names, own.tolist(), strict=True)))


def _of_body(fit: RigidFit, body: str, own: Mapping[str, float]) -> dict[str, float]:
    """Mass, centre of mass and inertia about it from the parameters at the joint."""
    mass = own[f"{body}.mass"]
    moment = np.array([own[f"{body}.first_moment.{axis}"] for axis in "xyz"])
    if mass == 0 and np.any(moment):
        raise ZeroDivisionError
    center = moment / mass if mass else moment
    at_joint = {entry: own[f"{body}.inertia_at_joint.{entry}"] for entry in INERTIA_COMPONENTS}
    about_center = inertia_at_joint(at_joint, mass, center, sign=-1.0)
    for entry in INERTIA_COMPONENTS:  # what no motion shows stays as it is about the centre, wherever that moves
        if f"{body}.inertia_at_joint.{entry}" in fit.base.without_effect:
            about_center[entry] = fit.robot.parameters[f"{body}.inertia.{entry}"].value
    return {
        f"{body}.mass": mass,
        **{f"{body}.center_of_mass.{axis}": float(center[place]) for place, axis in enumerate("xyz")},
        **{f"{body}.inertia.{entry}": value for entry, value in about_center.items()},
    }
