"""All torques of a motor or of an arm in proportion to each other: what a log of torques tells least."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.tolerance import KINDS
from flexros.gap.fit.estimates import unit_of_parameter

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.robot import Robot

SLIGHT = 0.03
"""Error of the gain of a torque up to which it counts as nominal [1] (chosen)."""
OF_TORQUES = tuple(ending for kind in ("stiffness", "damping", "inertia") for ending in KINDS[kind])
"""Endings of the names of numbers to which torques are in proportion."""


def in_proportion(fit: CandidateFit, gain: Candidate) -> CandidateFit:
    """Divide all torques that a motor meets by the gain of its own, as they are where that is nominal.

    Those of springs too where it is the only motor of the arm.

    Args:
        fit: An explanation.
        gain: An error of the torque gain among its effects.
    """
    values = fit.predictor.values(fit.theta)
    factor = 1 + values[fit.hypothesis.index(gain)]["relative"]
    return _divided(fit, factor, (gain.location,), springs=fit.predictor.robot.n_motors == 1)


def _divided(fit: CandidateFit, factor: float, motors: Sequence[str], *, springs: bool) -> CandidateFit:
    """Divide all torques that some motors meet, but for gains, by a factor.

    Args:
        fit: An explanation.
        factor: The factor [1].
        motors: The motors.
        springs: Whether those of springs and of loads are divided as well.
    """
    theta, robot = fit.theta.copy(), fit.predictor.robot
    values = fit.predictor.values(fit.theta)
    frees = [(one, free, own[free.name]) for one, own in zip(fit.hypothesis, values, strict=True) for free in one.free]
    for column, (candidate, free, size) in enumerate(frees):
        if (springs or candidate.location in motors) and _of_torque(candidate, free.name, fit):
            known = _known(candidate, robot)
            theta[column] = np.clip(free.encode((known + size) / factor - known), *free.bounds)
    return replace(fit, theta=theta)


def other_scales(search: Search, fit: CandidateFit) -> Iterator[CandidateFit]:
    """Yield where explanations begin that have another scale of all torques than one with errors of their gains.

    Without gravity, or where the load and the rotors of an arm are missing, one gain that is 8 % too small predicts as
    those of all other motors that are 8 % too large, in an arm that is as much too heavy. So each gain is tried as the
    nominal one, where no more gains are wrong then.

    Args:
        search: The search.
        fit: The explanation.
    """
    robot = fit.predictor.robot
    gains = {one.location: one for one in fit.hypothesis if one.effect is TorqueGainError}
    others = {one.location: one for one in search.candidates() if one.effect is TorqueGainError}
    if robot.n_motors == 1 or not gains.keys() <= set(robot.joint_names):
        return
    values = dict(zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True))
    found = {motor: 1 + values[gain]["relative"] for motor, gain in gains.items()}
    tried = []
    for factor in found.values():
        errors = {motor: found.get(motor, 1.0) / factor - 1 for motor in robot.joint_names}
        wrong = {motor: error for motor, error in errors.items() if abs(error) > SLIGHT}
        known = wrong.keys() <= others.keys() | gains.keys()
        if abs(factor - 1) > SLIGHT and len(wrong) <= len(gains) and known and wrong.keys() not in tried:
            tried.append(wrong.keys())
            yield _scaled(search, fit, factor, {gains.get(motor) or others[motor]: e for motor, e in wrong.items()})


def _scaled(search: Search, fit: CandidateFit, factor: float, errors: Mapping[Candidate, float]) -> CandidateFit:
    """Divide all torques of an arm by a factor, and take other errors of gains.

    Args:
        search: The search.
        fit: An explanation.
        factor: The factor [1].
        errors: The errors of the gains [1].

    Returns:
        The explanation, not fitted yet.
    """
    gains = [one.name for one in fit.hypothesis if one.effect is TorqueGainError]
    scaled = _divided(fit, factor, fit.predictor.robot.joint_names, springs=True)
    own = scaled.theta[: fit.predictor.n_effect][~fit.columns(gains)[: fit.predictor.n_effect]]
    sizes = [one.free[0].encode(error) for one, error in errors.items()]
    rest = tuple(one for one in fit.hypothesis if one.name not in gains)
    predictor = search.null.predictor((*rest, *errors))
    tolerance = fit.predictor.tolerance
    stated = np.array(tolerance.deviations)
    heavier = np.array([name.endswith(OF_TORQUES) for name in tolerance.names]) & (stated > 0)
    lighter = tolerance.along(np.where(heavier, np.log(factor) / np.where(heavier, stated, 1.0), 0.0))
    start = np.concatenate([own, sizes, fit.deviations - lighter])
    return replace(fit, predictor=predictor, theta=np.clip(start, *predictor.bounds))


def _of_torque(candidate: Candidate, name: str, fit: CandidateFit) -> bool:
    """Return whether torques are in proportion to a parameter of a candidate."""
    robot, effect = fit.predictor.robot, candidate.effect
    if issubclass(effect, AbstractRelativeError):
        return all(number.endswith(OF_TORQUES) for number in effect().numbers(robot, candidate.location))
    return unit_of_parameter(candidate, name, robot).startswith(("N", "kg"))


def _known(candidate: Candidate, robot: Robot) -> float:
    """Return what the model has of an effect already, in the unit of its size."""
    if issubclass(candidate.effect, AbstractRelativeError):
        return 1.0
    return (
        robot.parameters[f"{candidate.location}.viscous_friction"].value if candidate.effect is ViscousFriction else 0.0
    )
