"""Regrouping: several changes that stand for fewer others, which no exchange of one effect for one finds."""

from __future__ import annotations

from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.fit.directions import Directions, changes_of
from flexros.gap.search.elimination.clear_sizes import unclear
from flexros.gap.search.elimination.reduce import one_by_one
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.worth import compared

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from flexros.effects import AbstractEffect
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.screening import Surroundings
    from flexros.gap.search.fits.candidate_fits import Search

FEWEST = 2
"""Changes of an explanation from which others may stand for all of them [1]."""
TRIED = 2
"""Sets that are fitted, the smallest ones that linear theory finds good enough (chosen)."""
OF_MOTORS: Mapping[type[AbstractEffect], str] = MappingProxyType(
    {MotorInertiaError: "inertia", ViscousFriction: "viscous_friction"}
)
"""Numbers of a motor that a gain of its torque scales, by the effects that are errors of them."""
ALIKE = 0.02
"""Share of what changes do that fewer ones may leave of it by linear theory, in a measured log [1] (chosen)."""
MINOR = 0.1
"""Share of what several gains do that is left to other changes [1] (chosen)."""
LESS = 0.2
"""Share of what an explanation leaves that gains must explain before what stands for them is left out [1] (chosen)."""
RISE = 0.1
"""Rise of the sum of squares with fewer effects, over the sum, in a measured log [1] (chosen)."""
SLACK = 10.0
"""Rise of the score that linear theory may miss by, over the penalty of the parameters that are saved [1] (chosen)."""


def regrouped(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Replace the small changes of an explanation together by fewer ones, where these do as well.

    Numbers of the model, gains and offsets act in proportion to their size. What one of them does, several others do
    together, and forward selection, which adds one after the other, may end there: a gain and a load of a thousandth
    became two inertias, a spring, a gain and an offset. Without any of them linear theory tells how much every set of
    them leaves. The smallest good ones are fitted, and taken where their score is better. In a measured log a change
    that several motors feel takes the place of numbers of these motors where it leaves about as much: the load of a
    gantry became three rotors and a constant force.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    own = [one for one in fit.hypothesis if in_proportion(one)]
    if len(own) < FEWEST or search.deadline.stops():
        return fit
    known = {one.candidate.name: one for one in directions if in_proportion(one.candidate) and one.usable.any()}
    names = frozenset(one.name for one in own)
    known |= {one.candidate.name: one for one in _removals(search, fit, [one for one in own if one.name not in known])}
    competing = [one for name, one in known.items() if name in names or name not in fit.names]
    places = {one.candidate.name: place for place, one in enumerate(competing)}
    columns, off = fit.columns(names), fit.switched_off(names)
    around = search.surroundings(fit)
    change = changes_of(fit, search.data, fit.residual(search.data), search.rows, off[:, None])[:, 0]
    rest = around.without(columns, change)
    smallest = [int(np.argmin(np.where(one.usable, np.abs(one.starts[0]), np.inf))) for one in competing]
    changes = np.stack([one.changes[:, start] for one, start in zip(competing, smallest, strict=True)], axis=-1)
    now = tuple(sorted(places[name] for name in names))
    sets = rest.best_sets(changes, len(own) - 1, now)
    before = max(rest.left(changes[:, now]), 1e-300)
    if not search.premises.library_is_complete:
        sets = [members for members in sets if _are_felt_by_several(search, names, [competing[one] for one in members])]
    alike = [members for members in sets if _does_as_well(search, rest, changes[:, members], before, len(own))]
    trials = []
    for members in alike[:TRIED]:
        sizes = rest.sizes(changes[:, members])
        trials.append([_sized(search, competing[one], smallest[one], size) for one, size in zip(members, sizes)])
    fitted = search.parallel("effects regrouped", partial(search.together, fit, without=names), trials)
    better = [search.completed(one) for one in search.visible(fitted)]
    fits += better
    comparison = compared(search, [fit, *better])
    if search.premises.library_is_complete:
        return max([fit, *better], key=comparison.score)
    enough = [one for one in better if one.chi2 < (1 + RISE) * fit.chi2]
    return min(enough, key=lambda one: (len(one.hypothesis), one.chi2), default=fit)


def _are_felt_by_several(search: Search, names: frozenset[str], members: Sequence[Directions]) -> bool:
    """Return whether a set has other changes than an explanation, none of them at a motor, for those of several motors.

    Args:
        search: The search.
        names: Names of all its changes in proportion to a size.
        members: The set.
    """
    motors, kept = search.null.model.robot.joint_names, {one.candidate.name for one in members}
    new = [one.candidate for one in members if one.candidate.name not in names]
    of_motors = any(one.location in motors for one in new)
    gone = {name.partition("@")[2] for name in names - kept}
    return bool(new) and not of_motors and (len(gone) > 1 or not gone <= set(motors))


def _does_as_well(search: Search, rest: Surroundings, changes: NDArray[Any], before: float, n_own: int) -> bool:
    """Return whether fewer changes do about as well as those of an explanation by linear theory.

    Args:
        search: The search.
        rest: The explanation without its changes.
        changes: Changes of the prediction errors by the fewer ones, shape (n_rows, k).
        before: Sum of squares that those of the explanation leave [1].
        n_own: Their number.
    """
    left = float(rest.left(changes))
    if not search.premises.library_is_complete:  # large changes are not quite linear, and friction has other forms
        return left - before < ALIKE * (float(rest.least) - before)
    n = search.data.n_values
    saved = (n_own - changes.shape[1]) * float(np.log(n))
    return bool(n * np.log(max(left, 1e-300) / before) < (1 + SLACK) * saved)


def with_gains(
    search: Search, fit: CandidateFit, fits: list[CandidateFit], before: CandidateFit | None = None
) -> CandidateFit:
    """Free gains of torques beside an explanation of a measured log, and leave out the numbers that stand for them.

    A gain that is too large makes all numbers of a model look too small by the same factor: those of the rotor that
    torques show, and those within their tolerances. Beside these the gain promises little, and no exchange of one
    effect for one comes to it: gains that were 13 and 16 % off at both joints of an arm became a gain of 5 %, a rotor,
    viscous friction at both joints, and masses that were 3 tolerances too small. It is tried at motors of which a
    number is wrong.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
        before: An earlier explanation, in whose place the result is; default: this one.

    Returns:
        An explanation with no more effects that leaves less than the earlier one, or the same as given.
    """
    before = before or fit
    if search.premises.library_is_complete or search.deadline.stops():
        return fit
    robot = search.null.model.robot
    wrong = [one for one in fit.hypothesis if one.effect in OF_MOTORS]
    off = {one.location for one in wrong if robot.parameters[f"{one.location}.{OF_MOTORS[one.effect]}"].value > 0}
    every = (one for one in search.candidates() if one.effect is TorqueGainError)
    gains = [one for one in every if one.location in off and one.name not in fit.names]
    comparison = compared(search, [fit])
    if not gains or comparison.level(fit) > search.settings.ranking.floors:  # what is missing would be in the gains
        return fit
    nominal = search.with_nominal_numbers(fit)
    around = search.surroundings(nominal)
    additions = search.additions(search.directions(gains, nominal), nominal, around)
    changes = np.stack([one.change for one in additions], axis=-1)
    if around.least - around.left(changes) < comparison.threshold:
        return fit
    matter = _that_matter(around, changes)
    sizes = around.sizes(changes[:, matter])
    sized = [additions[one].sized(size) for one, size in zip(matter, sizes, strict=True)]
    tried = [search.completed(search.together(nominal, sized))]
    if tried[0].chi2 > (1 - LESS) * before.chi2:  # what they stand for cannot go
        return fit
    rest = one_by_one(search, tried[0], tried, before.chi2)
    if rest.names == fit.names or len(rest.hypothesis) > len(before.hypothesis):
        return fit
    small = search.completed(rest)
    if small.chi2 > before.chi2:
        return fit
    fits += [*tried, small]
    return small


def _that_matter(around: Surroundings, changes: NDArray[Any]) -> list[int]:
    """Return which of several changes do most of what all of them do, by linear theory.

    Args:
        around: The explanation that they come to.
        changes: Changes of the prediction errors, shape (n_rows, k).
    """
    kept, gain = list(range(changes.shape[1])), around.least - around.left(changes)
    while len(kept) > 1:
        left = [around.left(changes[:, [one for one in kept if one != gone]]) for gone in kept]
        if around.least - min(left) < (1 - MINOR) * gain:
            break
        kept.pop(int(np.argmin(left)))
    return kept


def in_proportion(candidate: Candidate) -> bool:
    """Return whether the prediction errors change in proportion to the only parameter of a candidate."""
    return candidate.effect.plain and len(candidate.free) == 1 and candidate.free[0].signed


def _removals(search: Search, fit: CandidateFit, own: Sequence[Candidate]) -> list[Directions]:
    """Return changes of the prediction errors by effects of an explanation, which begins with them, one at a time."""
    if not own:
        return []
    columns = [fit.columns(frozenset({one.name})) for one in own]
    off = np.stack([fit.switched_off(frozenset({one.name})) for one in own], axis=-1)
    changes = -changes_of(fit, search.data, fit.residual(search.data), search.rows, off).astype(np.float32)
    usable = np.ones(1, dtype=bool)
    return [
        Directions(one, fit.theta[column][:, None], changes[:, [k]], usable)
        for k, (one, column) in enumerate(zip(own, columns, strict=True))
    ]


def _sized(search: Search, direction: Directions, start: int, size: float) -> Addition:
    """Return a candidate with the size that linear theory gives it among others."""
    n_names = len(search.null.fit.predictor.tolerance.names)
    own, change = direction.starts[:, start], direction.changes[:, start]
    return Addition(direction.candidate, 0.0, own, np.zeros(n_names, dtype=bool), change).sized(float(size))


def without_tangled(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Keep one of several effects of a measured log none of which is clear beside the others, where that scores better.

    A load, a payload error and an offset of an encoder that stand for the payload error alone are each needed beside
    the other two, whose sizes balance them.

    Args:
        search: The search.
        fit: The explanation.
        fits: All fits so far; new ones are appended.
    """
    if search.premises.library_is_complete:
        return fit
    while not search.deadline.stops():
        tangled = unclear(search, fit, search.settings.search.clear)
        if len(tangled) < FEWEST:
            break
        groups = [[name for name in tangled if name != kept] for kept in tangled]
        without = search.parallel("effects regrouped", partial(_without, search, fit), groups)
        whole = [search.completed(one) for one in without if one.hypothesis]
        fits += whole
        comparison = compared(search, [fit, *whole])
        best = max([fit, *whole], key=comparison.score)
        if best is fit:
            break
        fit = best
    return fit


def _without(search: Search, fit: CandidateFit, names: Sequence[str]) -> CandidateFit:
    return search.without(fit, *names)
