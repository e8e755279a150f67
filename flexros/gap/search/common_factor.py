"""Common factor: numbers of a servo that positions determine up to a factor alone, so that any one may be nominal."""

from __future__ import annotations

from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.servos import ServoDampingError, ServoStiffnessError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.candidate import Candidate, free_parameter
from flexros.gap.search.elimination.reduce import reduced
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.proportion import in_proportion
from flexros.gap.search.servos.braking import braking_of, named
from flexros.gap.search.worth import compared, worth
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
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
    chosen = _with_one_gain(search, _with_friction(search, chosen, fits), fits)
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


def _with_friction(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Name missing damping of a servo viscous friction where the robot file has as much of that.

    The fit of all numbers at once, with which the search began, may have had to take more away.
    """
    robot = search.null.model.robot
    found = named(chosen, braking_of(search.candidates(), robot), search.null)
    if found.names == chosen.names:
        return chosen
    fits[:] = [one for one in fits if one.names != chosen.names]  # the same by another name is no rival
    fits.append(search.completed(found))
    return fits[-1]


def _with_one_gain(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Name stiffness and damping of a servo that are wrong by the same factor one wrong gain of its torque.

    A wrong torque constant scales both. Damping, or the viscous friction that acts as more of it does, is exchanged for
    a gain g, which predicts the same with a stiffness error s' of 1 + s = (1 + g) (1 + s'): it goes where s' is none.
    Both errors take over what the gains of the servo deviate by within their tolerance.
    """
    removed, robot = search.settings.search.removed_of_all, chosen.predictor.robot
    for motor in robot.joint_names:
        pair = None if search.deadline.stops() else _stiffness_and_damping(chosen, motor)
        gain = Candidate(TorqueGainError, motor, (free_parameter("relative", TorqueGainError.ranges["relative"], 1.0),))
        if pair is None or gain.name in chosen.names or not search.competitors.contain(gain):
            continue
        (stiffness, s), (damping, g) = pair
        sizes = ((gain, g), (stiffness, (1 + s) / (1 + g) - 1))
        starts = [(one, np.array([one.free[0].encode(size)])) for one, size in sizes]
        if any(not low <= start[0] <= high for one, start in starts for low, high in [one.free[0].bounds]):
            continue
        taken = np.array([name in _gains_of(motor) for name in chosen.predictor.tolerance.names], dtype=bool)
        unknown = np.zeros(len(search.rows), dtype=np.float32)
        additions = [Addition(one, 0.0, start, taken, unknown) for one, start in starts]
        trial = search.completed(search.together(chosen, additions, without=(stiffness.name, damping.name)))
        if search.torques_decide:
            small = reduced(search, trial, [], removed)
        else:  # the product of two large errors is not linear
            small = search.completed(search.without(trial, stiffness.name))
        fewer = len(small.hypothesis) < len(chosen.hypothesis) and stiffness.name not in small.names
        if fewer and not worth(search, compared(search, [small, chosen]), small, chosen, removed):
            fits.append(small)
            chosen = small
    return chosen


def _gains_of(motor: str) -> tuple[str, str]:
    """Return the names of stiffness and damping of the servo of a motor."""
    return f"{motor}.{SERVO}stiffness", f"{motor}.{SERVO}damping"


def _stiffness_and_damping(fit: CandidateFit, motor: str) -> tuple[tuple[Candidate, float], ...] | None:
    """Return the effects of a fit on stiffness and damping of a servo, with relative errors [1]; None without both.

    The errors contain the deviations of these gains within their tolerance. Viscous friction counts as damping where no
    error of that is named.

    Args:
        fit: The fit.
        motor: The motor.
    """
    found = zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
    own = {one.effect: (one, sizes) for one, sizes in found if one.location == motor}
    parameters, tolerance = fit.predictor.robot.parameters, fit.predictor.tolerance
    nominal = parameters[_gains_of(motor)[1]].value if _gains_of(motor)[1] in parameters else 0.0
    braking = next((effect for effect in (ServoDampingError, ViscousFriction) if effect in own), None)
    if ServoStiffnessError not in own or braking is None or not nominal:
        return None
    factors = dict(zip(tolerance.names, np.exp(tolerance.logarithms(fit.deviations)).tolist(), strict=True))
    of_stiffness, of_damping = (factors.get(name, 1.0) for name in _gains_of(motor))
    (stiffness, error), (damping, sizes) = own[ServoStiffnessError], own[braking]
    if damping.effect is ServoDampingError:
        braked = of_damping * (1 + sizes["relative"])
    else:
        braked = of_damping + sizes["coefficient"] / nominal
    return (stiffness, of_stiffness * (1 + error["relative"]) - 1), (damping, braked - 1)


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
        fits.append(search.without(in_proportion(chosen, gain), gain.name))
        if not worth(search, compared(search, [fits[-1], chosen]), fits[-1], chosen, removed):
            chosen = reduced(search, fits[-1], fits, removed)
    return chosen


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
