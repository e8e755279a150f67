"""Numbers of the model in a complete explanation: errors within tolerance are none, those far beyond it are named."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.gap.candidates.tolerance import FARTHEST
from flexros.gap.fit.least_squares import fit as fit_candidate
from flexros.gap.fit.limits import ended_at_last
from flexros.gap.fit.tolerance_takeover import friction_takeover, takeover
from flexros.gap.search.exchange import exchanged
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.model_probability import compare
from flexros.gap.search.worth import FAR, compared, worth
from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import motion_cutoff, smooth_motion

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.search.fits.candidate_fits import Search

WITHIN = 2.0
"""Deviation of viscous friction over its tolerance up to which it is none [1] (chosen): 95 %."""


def with_far_numbers(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Name the errors of numbers of the model that a good explanation moves far out of tolerance.

    The prior of tolerances counts little beside many samples, so that a spring that is a fifth too soft is within a
    tolerance of 3 % for all that predictions say, and no effect gains by taking its place. By what the tolerance means
    it is wrong. An explanation that leaves more than its floors draws numbers out of tolerance for what it lacks.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits so far; new ones are appended.
    """
    if search.premises.floor_is_noise:
        return chosen
    refused: set[str] = set()
    begun = chosen
    while not search.deadline.stops_finishing():
        within = compared(search, [chosen]).level(chosen) <= search.settings.ranking.floors
        least = FAR if within else FARTHEST
        found = _farthest(search, chosen, refused, least)
        if found is None:
            break
        fits.append(search.completed(search.together(chosen, [found])))
        named, name = fits[-1], found.candidate.name
        freed = chosen.prior_penalty - named.prior_penalty
        far = _tolerances(search, named, found.candidate) > least and name not in ended_at_last(named)
        if far and named.chi2 < chosen.chi2 and freed > least**2 / 2:
            chosen = named
        refused.add(name)
    return chosen if chosen is begun else _exchanged_beside(search, chosen, chosen.names - begun.names, fits)


def _exchanged_beside(
    search: Search, named: CandidateFit, further: frozenset[str], fits: list[CandidateFit]
) -> CandidateFit:
    """Exchange effects that stood for a part of the numbers that are named now, where others beside them leave less.

    A payload that was 30 % too light and a torque that was 8 % too weak at the lift below it balance each other in what
    the lift carries. Torques show an inertia at the wrist, where a gain took its place before the payload was named:
    that is as real no longer, and competes with all candidates.

    Args:
        search: The search.
        named: The explanation.
        further: Names of the effects that are the errors of these numbers.
        fits: All fits so far; new ones are appended.
    """
    other = exchanged(search, named, search.directions(search.candidates(), named), fits, shown=search.of_torques)
    gained = search.data.n_values * np.log(named.chi2 / other.chi2)
    return other if further <= other.names and gained > compared(search, [named, other]).threshold else named


def without_slight_friction(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out friction whose torque is a small part of what is tolerated at its motor, or that is tolerated itself.

    However clear it is, nobody asks for it, and the numerical friction of a simulator is of that size. Friction that
    differs between directions stays, as its mean may be nominal. Viscous friction within the tolerance that the robot
    file states for it is no effect, unless the explanation needs more of it than these numbers give.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits so far; new ones are appended.
    """
    if search.premises.floor_is_noise or search.data.record.command is not None:
        return chosen
    for is_none, at_any_price in ((_is_slight_friction, True), (_is_tolerated, False)):
        values = zip(chosen.hypothesis, chosen.predictor.values(chosen.theta), strict=True)
        none = [one.name for one, sizes in values if len(one.free) == 1 and is_none(search, one, sizes)]
        if not none or len(none) == len(chosen.hypothesis) or search.deadline.stops_finishing():
            continue
        rest, removed = search.completed(search.without(chosen, *none)), search.settings.search.removed_of_all
        fits.append(rest)
        if at_any_price or not worth(search, compared(search, [rest, chosen]), rest, chosen, removed):
            chosen = rest
    return chosen


def _is_slight_friction(search: Search, one: Candidate, sizes: Mapping[str, float]) -> bool:
    """Return whether the torque of Coulomb friction, or of viscous friction at the rms speed, is hardly anything."""
    if one.effect not in (CoulombFriction, ViscousFriction):
        return False
    data, motor = search.data, search.null.model.robot.joint_names.index(one.location)
    record = data.record
    position = bridged_motion(record.position[:, [motor]], record.valid)
    speed = smooth_motion(position, record.sample_time, motion_cutoff(record.sample_time))[1]
    usual = 1.0 if one.effect is CoulombFriction else float(np.sqrt(np.mean(speed**2)))
    least = search.settings.search.least_of_tolerance * float(data.measurement.tolerated_torque(record)[motor])
    return abs(sizes[one.free[0].name]) * usual < least


def _is_tolerated(search: Search, one: Candidate, sizes: Mapping[str, float]) -> bool:
    """Return whether a nominal viscous friction with this in addition is within a few of its tolerances."""
    if one.effect is not ViscousFriction:
        return False
    (number,) = one.effect().numbers(search.null.model.robot, one.location)
    nominal = search.null.model.robot.parameters[number].value
    tolerance = search.null.fit.predictor.tolerance.largest((number,))
    return nominal > 0 and _deviation(nominal, sizes["coefficient"]) <= WITHIN * tolerance


def _deviation(nominal: float, added: float) -> float:
    """Return the size of the logarithm of a number over its nominal value [1]."""
    return abs(float(np.log(max(1 + added / nominal, 0.01))))


def _farthest(search: Search, chosen: CandidateFit, refused: set[str], least: float) -> Addition | None:
    """Return the error that takes over most of the deviations of an explanation; None where none is far.

    Args:
        search: The search.
        chosen: The explanation.
        refused: Names of the errors that were tried.
        least: Deviation from which a number is far [1].
    """
    best: Addition | None = None
    for one in search.candidates():
        if one.name in chosen.names | refused:
            continue
        found = friction_takeover(one, chosen) if one.effect is ViscousFriction else None
        if issubclass(one.effect, AbstractRelativeError):
            found = takeover(one, chosen)
        if found is not None and found.gain > max(least**2, 0.0 if best is None else best.gain):
            best = Addition(one, found.gain, found.start, found.replaced, np.zeros(len(search.rows), dtype=np.float32))
    return best


def _tolerances(search: Search, fit: CandidateFit, candidate: Candidate) -> float:
    """Return the size of an error of an explanation over the tolerance of the numbers that it changes [1]."""
    robot = search.null.model.robot
    changed = candidate.effect().numbers(robot, candidate.location)
    values = next(v for one, v in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True) if one is candidate)
    least = search.null.fit.predictor.tolerance.largest(changed)
    if "relative" in values:
        return _deviation(1.0, values["relative"]) / max(least, 1e-300)
    return _deviation(robot.parameters[changed[0]].value, values["coefficient"]) / max(least, 1e-300)


def without_tolerated(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out errors of numbers of the model that their tolerances take up.

    The prior of tolerances weighs by what the first effects of a measured log leave, the misfit. Where the explanation
    leaves far less in the end, it weighs too much then, and the error of a number seems to be worth its parameter
    because the same deviation within tolerance costs that much. So each is compared with the deviations at the misfit
    that the explanation leaves.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits so far; new ones are appended.
    """
    comparison = compared(search, [chosen])
    left = max(comparison.level(chosen), 1.0)
    if search.premises.floor_is_noise or search.data.misfit <= left:
        return chosen
    data, removed = replace(search.data, misfit=left), search.settings.search.removed_of_all
    settings = search.settings.fit

    def fitted(predictor: Predictor, start: FloatArray) -> CandidateFit:
        enough, most = max(settings.exactly, data.negligible), settings.final_iterations
        stop = search.deadline.of_fit(finishing=True)
        return fit_candidate(predictor, data, start, most, enough=enough, settings=settings, stop=stop)

    numbers = [one for one in chosen.hypothesis if takeover(one, chosen) and one.name not in search.of_torques]
    if not numbers:
        return chosen
    full = fitted(chosen.predictor, chosen.theta)
    for one in numbers:
        if len(chosen.hypothesis) == 1 or search.deadline.stops_finishing():
            break
        rest = tuple(other for other in full.hypothesis if other is not one)
        start = full.theta[~full.columns([one.name])]
        without = fitted(search.null.predictor(rest), start)
        both = compare(data, search.null.fit, [without, full], search.distance, search.chance, search.settings.ranking)
        if not worth(search, both, without, full, removed):
            full, chosen = without, search.completed(search.without(chosen, one.name))
            fits.append(chosen)
    return chosen
