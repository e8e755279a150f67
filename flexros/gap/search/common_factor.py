"""Common factor: numbers of a servo that positions determine up to a factor alone, so that any one may be nominal."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.fit.estimates import unit_of_parameter
from flexros.gap.search.elimination import reduced
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search

ALIKE = 0.1
"""Least squared correlation of two sizes, all others free, of which one may stand for the other [1] (chosen): 0.2 to 1
at wrists, least beside a load."""
DOUBTFUL = 100.0
"""Rise of the sum of squares without an effect up to which it may go, with another one free, by linear theory [1]
(chosen): far sizes leave so much that a fit closes."""


def with_other_scales(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Fit an explanation of a log without torques with other numbers of a servo nominal, as rivals of it.

    At a joint that gravity does not load, gain, damping, inertia and friction have a common factor. With wrong friction
    and gain, the log is explained alike by a wrong gain and a wrong inertia, and the search ends with one of the two.
    It also ends with two wrong numbers where a single one of another kind is enough, which is taken instead, or with
    two that stand for nothing together, which are left out.

    Args:
        search: The search.
        chosen: The explanation, at its end.
        fits: All fits so far; new ones are appended.
    """
    if search.data.record.command is None:
        return chosen
    removed = search.settings.search.removed_of_all
    chosen = _without_gains(search, chosen, fits)
    while not search.deadline.stops() and (smaller := _without_pair(search, chosen, fits)) is not None:
        chosen = smaller
    while not search.deadline.stops():
        rivals = _rivals(search, chosen)
        fits += rivals
        near = [one for one in rivals if _as_good(search, one, chosen)]
        fewer = [reduced(search, one, fits, removed) for one in near]
        best = min(fewer, key=lambda one: (len(one.hypothesis), one.chi2), default=chosen)
        if len(best.hypothesis) >= len(chosen.hypothesis):
            break
        if worth(search, compared(search, [best, chosen]), best, chosen, removed):
            break
        chosen = best
    return chosen


def _without_gains(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out wrong gains of torques where other friction and inertia at their motors explain the log as well.

    Fits that begin at the sizes that these have beside a gain do not come to those in proportion.
    """
    removed = search.settings.search.removed_of_all
    for gain in [one for one in chosen.hypothesis if one.effect is TorqueGainError]:
        if search.deadline.stops() or len(chosen.hypothesis) == 1:
            break
        if gain not in chosen.hypothesis:  # it went together with another one
            continue
        fits.append(search.without(_in_proportion(chosen, gain), gain.name))
        if not worth(search, compared(search, [fits[-1], chosen]), fits[-1], chosen, removed):
            chosen = reduced(search, fits[-1], fits, removed)
    return chosen


def _in_proportion(fit: CandidateFit, gain: Candidate) -> CandidateFit:
    """Divide all torques that a motor meets by the gain of its own, as they are where that is nominal."""
    theta, robot, motor = fit.theta.copy(), fit.predictor.robot, gain.location
    values = fit.predictor.values(fit.theta)
    factor = 1 + values[fit.hypothesis.index(gain)]["relative"]
    frees = [(one, free, own[free.name]) for one, own in zip(fit.hypothesis, values, strict=True) for free in one.free]
    viscous = robot.parameters[f"{motor}.viscous_friction"].value
    for column, (candidate, free, size) in enumerate(frees):
        relative = candidate.effect is MotorInertiaError
        if candidate.location == motor and (relative or unit_of_parameter(candidate, free.name, robot).startswith("N")):
            known = 1.0 if relative else viscous if candidate.effect is ViscousFriction else 0.0
            theta[column] = np.clip(free.encode((known + size) / factor - known), *free.bounds)
    return replace(fit, theta=theta)


def _without_pair(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit | None:
    """Leave out two numbers of a servo that are worth their parameters beside each other alone; None without such.

    A wrong gain of both stiffness and damping, and viscous friction that undoes the latter, are nothing more than a
    wrong stiffness; without either of the two the other one is far off.
    """
    each = combinations(chosen.hypothesis, 2)
    pairs = [(one.name, other.name) for one, other in each if one.location == other.location]
    around, removed = search.surroundings(chosen), search.settings.search.removed_of_all
    rests = search.removals_together(chosen, around, pairs)
    rises = sorted((rest.least - around.least, pair) for rest, pair in zip(rests, pairs, strict=True))
    for rise, pair in rises:
        if rise > DOUBTFUL or search.deadline.stops():
            break
        fits.append(search.without(chosen, *pair))
        if not worth(search, compared(search, [fits[-1], chosen]), fits[-1], chosen, removed):
            return fits[-1]
    return None


def _rivals(search: Search, chosen: CandidateFit) -> list[CandidateFit]:
    """Fit an explanation with numbers of a servo exchanged, and with those that do as well at the same servo once more.

    Of three numbers any two may explain a log, and only one exchange of each explanation be near by linear theory.
    """
    fits: list[CandidateFit] = []
    known, begun = {chosen.names}, [(chosen, "")]
    while begun and not search.deadline.stops():
        around, servo = begun.pop(0)
        trials = {
            around.names - {name} | {addition.candidate.name}: (name, addition)
            for name, addition in _exchanges(search, around)
            if servo in ("", addition.candidate.location)
        }
        new = [trial for names, trial in trials.items() if names not in known]
        known |= trials.keys()
        found = search.parallel("other scales", partial(_exchanged, search, around), new)
        fits += [one for one, _ in found]
        begun += [(one, place) for one, place in found if _as_good(search, one, chosen)]
    return fits


def _as_good(search: Search, one: CandidateFit, chosen: CandidateFit) -> bool:
    return one.chi2 - chosen.chi2 < compared(search, [one]).threshold


def _exchanges(search: Search, chosen: CandidateFit) -> list[tuple[str, Addition]]:
    """List the numbers of servos that may be nominal by linear theory, each with one that is wrong in its place."""
    own = [one for one in chosen.hypothesis if one.name in search.of_torques]
    servos = {one.location for one in own}
    nominal = [one for one in search.base.hypothesis if one.location in servos and not one.effect.one_level]
    directions = search.directions([one for one in nominal if one.name not in chosen.names], chosen)
    around = search.surroundings(chosen)
    exchanges = []
    for one, rest in zip(chosen.hypothesis, search.removals(chosen, around), strict=True):
        for direction in directions:
            if one not in own or one.location != direction.candidate.location:
                continue
            smallest = direction.changes[:, np.argmin(np.abs(direction.starts[0]))]
            alike = around.alike(int(np.argmax(chosen.columns((one.name,)))), smallest)
            if alike > ALIKE and (rest.least - chosen.chi2) * (1 - alike) < DOUBTFUL:
                exchanges += [(one.name, addition) for addition in search.additions([direction], chosen, rest)]
    return exchanges


def _exchanged(search: Search, chosen: CandidateFit, trial: tuple[str, Addition]) -> tuple[CandidateFit, str]:
    """Fit an explanation with another effect in place of one of its own, to the end where it comes near.

    Returns:
        The fit, and the motor of the effect.
    """
    name, addition = trial
    found = search.together(chosen, [addition], without=(name,), rival=chosen.chi2)
    near = found.chi2 - chosen.chi2 < search.settings.search.little * search.data.n_values
    return search.completed(found) if near else found, addition.candidate.location
