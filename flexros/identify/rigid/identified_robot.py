"""Robot file with the parameters of a rigid regression."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.feasible_bodies import feasible_parameters
from flexros.identify.rigid.prior import prior_factor
from flexros.identify.rigid.standard_parameters import inertia_at_joint
from flexros.identify.robot_file import IdentifiedValue, identified_file
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from flexros.arrays import FloatArray
    from flexros.identify.rigid.fit import RigidFit

_LEAST_EFFECT = 1e-9
"""Relative change of a parameter below which the regression does not affect it (chosen: round-off)."""

_MISSED = 1e-3
"""Relative difference above which a base parameter is not met, where its deviation is smaller (chosen)."""

_LIKELY = 0.1
"""Weight of likely values against the torque in the search for a feasible robot (chosen): what the torque tells counts
a hundred times as much."""

_INERTIAL = ("inertia_at_joint", "first_moment", "mass")
"""Kinds of inertial parameters, which a body has only together."""


@dataclass(frozen=True, eq=False)
class IdentifiedRobot:
    """Parameters of the robot file that follow from a rigid fit.

    Attributes:
        values: New value and relative standard deviation by parameter name.
        left_out: Reasons for nominal values, by name of the body, or of the parameter where it is not inertial.
        not_met: Base parameters whose value in the file differs from the identified one because of left-out parameters:
            the value in the file by name.
        base_values: Values of all base parameters in the file, shape (r,); identified values of parameters that a file
            cannot hold, such as Coulomb friction.
    """

    values: Mapping[str, IdentifiedValue]
    left_out: Mapping[str, str]
    not_met: Mapping[str, float]
    base_values: FloatArray


def identified_values(fit: RigidFit) -> IdentifiedRobot:
    """Convert base parameters to parameters of the robot file, with their relative standard deviations.

    Base parameters are combinations, so many files give the identified torques; the most likely one according to the
    tolerances of the nominal values (`prior_factor`) is chosen. Its single parameters therefore depend on the nominal
    ones. Their deviations are those of the regression and, in the directions that it does not determine, of the nominal
    values. Infeasible values, such as a negative inertia, stay nominal, and the others are changed instead; or all are
    the feasible ones that explain the torque best, where these explain more.
    """
    left_out: dict[str, str] = {}
    while True:
        share = _most_likely_change(fit, left_out)
        values, refused = _values(fit, _change(fit, share), share, left_out)
        if not refused:
            got = _base_values(fit, _change(fit, share))
            nearest = IdentifiedRobot(values, left_out, _not_met(fit, got), got)
            return _better(fit, nearest) if left_out else nearest
        left_out.update(refused)


def _better(fit: RigidFit, nearest: IdentifiedRobot) -> IdentifiedRobot:
    """Return the feasible robot that explains the torque best, if it explains more of it than the one given."""
    share = _most_likely_change(fit, ())
    change = _feasible_change(fit, _change(fit, share))
    if change is None:
        return nearest
    values, refused = _values(fit, change, share, ())
    got = _base_values(fit, change)
    if refused or fit.force_error(got) >= fit.force_error(nearest.base_values):
        return nearest
    return IdentifiedRobot(values, {}, _not_met(fit, got), got)


def _feasible_change(fit: RigidFit, likely: FloatArray) -> FloatArray | None:
    """Changes of the parameters, shape (P,), with which a feasible robot explains the torque best; None without one.

    Where the torque tells nothing, values near the nominal ones in the sense of `prior_factor` are likely.

    Args:
        fit: The fit.
        likely: Most likely changes without regard to what is feasible, shape (P,).
    """
    names = [parameter.name for parameter in fit.base.standard]
    nominal = np.array([parameter.nominal for parameter in fit.base.standard])
    start = nominal.copy()
    bodies: dict[str, list[int]] = {}
    positive = []
    for index, name in enumerate(names):
        if "." not in _group(name):
            bodies.setdefault(_group(name), []).append(index)
        elif name in fit.robot.parameters:
            positive.append(index)
        elif index in fit.base.leading:
            start[index] = fit.values[fit.base.leading.index(index)]
    factor = prior_factor(fit.robot, fit.base)
    in_file = [*positive, *(index for rows in bodies.values() for index in rows)]
    inverse = np.linalg.pinv(factor[np.ix_(in_file, in_file)])
    size = np.sqrt(np.mean((inverse @ likely[in_file]) ** 2) * len(in_file)) or 1.0
    prior = np.zeros((len(in_file), len(names)))
    prior[:, in_file] = _LIKELY * inverse / size
    left = np.linalg.norm(fit.factor[:, :, -1] - fit.factor[:, :, :-1] @ fit.values, axis=0)
    rows = fit.factor / np.where(left > 0, left, 1.0)[:, None]
    rows = rows.reshape(-1, rows.shape[2])
    found = feasible_parameters(
        start,
        bodies,
        positive,
        np.concatenate([rows[:, -1], prior @ nominal]),
        np.concatenate([rows[:, :-1] @ fit.base.combination, prior]),
    )
    return None if found is None else found - nominal


def identified_yaml(fit: RigidFit, identified: IdentifiedRobot) -> str:
    """Return the text of the robot file with the identified values, their source and their tolerances."""
    source = f"identified by FlexROS, rigid regression of {fit.error.label}"
    return identified_file(fit.robot, identified.values, source)


def _most_likely_change(fit: RigidFit, left_out: Collection[str]) -> FloatArray:
    """Matrix from changes of the k excited base parameters to the most likely changes, shape (P, k).

    Base parameters for which too few parameters remain are approximated, in units of their likely changes.
    """
    factor = prior_factor(fit.robot, fit.base)
    factor[~np.any(fit.base.combination != 0, axis=0)] = 0.0  # no motion excites these
    seen = _seen(fit)
    unit = np.linalg.norm(seen @ factor, axis=1)
    factor[[_group(parameter.name) in left_out for parameter in fit.base.standard]] = 0.0
    share: FloatArray = factor @ np.linalg.pinv(seen @ factor / unit[:, None], rcond=1e-12) / unit
    return share


def _seen(fit: RigidFit) -> FloatArray:
    """Combinations of parameters that the regression attributes to base parameters, shape (k, P)."""
    shown, hidden = list(fit.excitation.shown), list(fit.hidden)
    seen: FloatArray = fit.base.combination[shown] + fit.leakage @ fit.base.combination[hidden]
    return seen


def _change(fit: RigidFit, share: FloatArray) -> FloatArray:
    """Changes of the parameters, shape (P,)."""
    shown = list(fit.excitation.shown)
    change: FloatArray = share @ (fit.values - fit.base.nominal)[shown]
    return change


def _covariance(fit: RigidFit, share: FloatArray) -> FloatArray:
    """Covariance of all parameters, shape (P, P): undetermined directions keep their prior uncertainty."""
    shown = list(fit.excitation.shown)
    left_open = (np.eye(len(share)) - share @ _seen(fit)) @ prior_factor(fit.robot, fit.base)
    covariance: FloatArray = share @ fit.covariance[np.ix_(shown, shown)] @ share.T + left_open @ left_open.T
    return covariance


def _values(
    fit: RigidFit, change: FloatArray, share: FloatArray, left_out: Collection[str]
) -> tuple[dict[str, IdentifiedValue], dict[str, str]]:
    """Parameters of the robot file that depend on estimates, and the reasons why others are infeasible."""
    covariance = _covariance(fit, share)
    values: dict[str, IdentifiedValue] = {}
    refused: dict[str, str] = {}
    groups: dict[str, list[int]] = {}
    for index, parameter in enumerate(fit.base.standard):
        groups.setdefault(_group(parameter.name), []).append(index)
    for group, members in groups.items():
        if group in left_out:
            continue
        try:
            new_values = _of_group(fit, group, members, change, covariance, share)
            fit.robot.with_values({name: entry.value for name, entry in new_values.items()}, "the regression")
        except ZeroDivisionError:
            refused[group] = "its mass is zero, so its first moment gives no centre of mass"
        except InputError as error:
            refused[group] = str(error)
        else:
            values.update(new_values)
    return values, refused


def _of_group(
    fit: RigidFit, group: str, members: list[int], change: FloatArray, covariance: FloatArray, share: FloatArray
) -> dict[str, IdentifiedValue]:
    """File parameters of a group of regression parameters, as far as they depend on estimates."""
    names = [fit.base.standard[member].name for member in members]
    standard = np.array([fit.base.standard[member].nominal for member in members]) + change[members]
    value = _file_parameters(fit, group, names, standard)
    slopes = np.zeros((len(value), len(members)))
    block = covariance[np.ix_(members, members)]
    largest = float(np.max(np.abs(standard))) or 1.0
    for column, step in enumerate(1e-5 * np.maximum(np.abs(standard), 1e-3 * largest)):
        if block[column, column] > 0:
            side = np.zeros(len(standard))
            side[column] = step
            above, below = (list(_file_parameters(fit, group, names, standard + s).values()) for s in (side, -side))
            slopes[:, column] = (np.array(above) - np.array(below)) / (2 * step)
    variance = np.einsum("ij,jk,ik->i", slopes, block, slopes)
    deviation = np.sqrt(np.maximum(variance, 0.0))
    shown = list(fit.excitation.shown)
    reach = np.max(np.abs(slopes @ share[members]) * fit.deviation[shown], axis=1, initial=0.0)
    return {
        name: IdentifiedValue(result, float(spread) / max(abs(result), 1e-300))
        for (name, result), spread, effect in zip(value.items(), deviation, reach, strict=True)
        if effect > _LEAST_EFFECT * max(abs(result), 1e-300)
    }


def _base_values(fit: RigidFit, change: FloatArray) -> FloatArray:
    """Values of the base parameters in the file, shape (r,); as identified where a file cannot hold them."""
    got = fit.base.nominal.copy()
    got[list(fit.excitation.shown)] += _seen(fit) @ change
    groups = [_group(name) for name in fit.base.names]
    outside = ["." in group and group not in fit.robot.parameters for group in groups]
    return np.where(outside, fit.values, got)


def _not_met(fit: RigidFit, got: FloatArray) -> dict[str, float]:
    """Values in the file of base parameters that differ by more than their deviation, the worst first."""
    missed = np.zeros(len(fit.values), bool)
    shown = list(fit.excitation.shown)
    size = np.maximum(np.maximum(np.abs(fit.values), np.abs(fit.base.nominal)), 1e-300)
    distance = np.abs(got - fit.values)
    missed[shown] = (distance > np.maximum(fit.deviation, _MISSED * size))[shown]
    worst_first = sorted(np.flatnonzero(missed), key=lambda index: -distance[index] / size[index])
    return {fit.base.names[index]: float(got[index]) for index in worst_first}


def _group(name: str) -> str:
    """Name of the group that is feasible as a whole: the inertial parameters of a body, or one parameter."""
    owner, _, kind = name.partition(".")
    if owner.startswith("body") and kind.split(".")[0] in _INERTIAL:
        return owner
    return f"{owner}.viscous_friction" if kind.startswith("viscous_friction") else name


def _file_parameters(fit: RigidFit, group: str, names: list[str], standard: FloatArray) -> dict[str, float]:
    """Parameters of the robot file from those of a group; friction is the mean of both directions."""
    if "." in group:
        return {group: float(np.mean(standard))} if group in fit.robot.parameters else {}
    return _of_body(fit, group, dict(zip(names, standard.tolist(), strict=True)))


def _of_body(fit: RigidFit, body: str, standard: Mapping[str, float]) -> dict[str, float]:
    """Mass, centre of mass and inertia about it from the parameters at the joint."""
    mass = standard[f"{body}.mass"]
    moment = np.array([standard[f"{body}.first_moment.{axis}"] for axis in "xyz"])
    if mass == 0 and np.any(moment):
        raise ZeroDivisionError
    center = moment / mass if mass else moment
    at_joint = {entry: standard[f"{body}.inertia_at_joint.{entry}"] for entry in INERTIA_COMPONENTS}
    about_center = inertia_at_joint(at_joint, mass, center, sign=-1.0)
    for entry in INERTIA_COMPONENTS:  # what no motion excites stays nominal about the centre, even if that moves
        if f"{body}.inertia_at_joint.{entry}" in fit.base.without_effect:
            about_center[entry] = fit.robot.parameters[f"{body}.inertia.{entry}"].value
    return {
        f"{body}.mass": mass,
        **{f"{body}.center_of_mass.{axis}": float(component) for axis, component in zip("xyz", center, strict=True)},
        **{f"{body}.inertia.{entry}": value for entry, value in about_center.items()},
    }
