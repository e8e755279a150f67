"""Elimination: effects without which hardly more is left, and what the torques of a measured log show of the rest."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import hypot, log, log1p
from typing import TYPE_CHECKING

from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.effects.torque_bias import TorqueBias
from flexros.gap.candidates.candidate import alike
from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.estimates import clearness, parameters_of, sizes_of
from flexros.gap.fit.torques.missing_load import moved_mass
from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.gap.search.worth import compared, more_than_chance, strains, worth

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.gap.candidates.candidate import Candidate, FreeParameter
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

ASYMMETRY = "asymmetry"
"""Parameter by which friction differs between the directions."""

NOTHING = 1e-3
"""Size over the largest one of its search below which an effect is none [1] (chosen): one of size zero seems to be
sharply known."""

STRAINED = 4
"""The least needed effects that are tried beside numbers out of tolerance, whatever linear theory says (chosen): an
imitation that stays attracts others. Every mode is tried too: springs and inertias take it over, far from its size."""

TRIED = 2
"""Effects without which an explanation is fitted at once (chosen): two that do the same compete."""

SEVERAL = 3
"""Needless effects from which they are left out at once (chosen): of two, two fits decide anyway."""


def reduced(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out the effects without which hardly more is left, one after the other, or several that are so together.

    Effects that are indispensable by linear theory are not tried, and those that seem least needed by it come first. An
    effect that gains less than its parameters cost is tried also where nothing is left above the floor, and so are the
    least needed ones of an explanation of a simulated log that draws numbers of the model out of tolerance.
    Without time for fits, and of the crowd of effects that torques show, all are left out at once that are needless by
    linear theory.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    settings = search.settings.search
    if not search.premises.floor_is_noise:
        removed = settings.removed_of_all
    certain = min(settings.indispensable, settings.certain * removed)
    at_once = True
    while len(fit.hypothesis) > 1:
        if search.torques_decide or search.deadline.stops_finishing():
            return _without_needless(search, fit, fits, removed)
        surroundings = search.surroundings(fit)  # of some rows: they tell how much is lost, not how much is left
        lost = [max(rest.least - surroundings.least, 0.0) for rest in search.removals(fit, surroundings)]
        doubt = partial(_is_doubtful, search, fit, certain)
        doubtful = [(rise, one.name) for one, rise in zip(fit.hypothesis, lost, strict=True) if doubt(rise, [one.name])]
        several = _doubtful_together(search, fit, [name for _, name in sorted(doubtful)], doubt) if at_once else ()
        if several:
            fits.append(search.without(fit, *several))
            at_once = not worth(search, compared(search, best_of_each(fits)), fits[-1], fit, removed)
            if at_once:
                fit = fits[-1]
                continue
        if search.premises.library_is_complete and compared(search, [fit]).beyond_tolerance(fit):
            # numbers of the model that an imitation drew out of tolerance go far without it: linear theory sees no end
            least = sorted((rise, one.name) for one, rise in zip(fit.hypothesis, lost, strict=True))
            modes = {one.name for one in fit.hypothesis if one.effect.stage == "structure"}
            tried = [pair for place, pair in enumerate(least) if place < STRAINED or pair[1] in modes]
            doubtful = [*doubtful, *(pair for pair in tried if pair not in doubtful)]
        rest = _without_one(search, fit, [name for _, name in sorted(doubtful)], fits, removed)
        if rest is None:
            break
        fit = rest
    return fit


def _is_doubtful(search: Search, fit: CandidateFit, certain: float, rise: float, names: Sequence[str]) -> bool:
    """Return whether effects may be left out by linear theory.

    Args:
        search: The search.
        fit: The fit.
        certain: Share of what a fit without them leaves, from which they are indispensable [1].
        rise: Rise of the sum of squares without them [1].
        names: Their names.
    """
    return rise < certain * (rise + max(fit.chi2 - search.data.n_values, 0.0)) or _gain_nothing(
        search, fit, names, rise
    )


def _doubtful_together(
    search: Search, fit: CandidateFit, names: Sequence[str], doubt: Callable[[float, Sequence[str]], bool]
) -> Sequence[str]:
    """Return the most doubtful effects that are so together; none where they are few.

    Two that do the same are needed together, and are left to `_without_one`.

    Args:
        search: The search.
        fit: The fit.
        names: The effects that are doubtful alone, the most doubtful first.
        doubt: Whether effects are, by the rise of the sum of squares without them and by their names.
    """
    surroundings = search.surroundings(fit)
    sets = [names[:number] for number in range(SEVERAL, min(len(names), len(fit.hypothesis) - 1) + 1)]
    found: Sequence[str] = ()
    for tried, rest in zip(sets, search.removals_together(fit, surroundings, sets), strict=True):
        found = tried if doubt(max(rest.least - surroundings.least, 0.0), tried) else found
    return found


def _gain_nothing(search: Search, fit: CandidateFit, names: Sequence[str], rise: float) -> bool:
    """Return whether effects gain less than their parameters cost, by the rise of the sum of squares without them."""
    n, parameters = search.data.n_values, sum(len(one.free) for one in fit.hypothesis if one.name in names)
    return n * log1p(rise / fit.chi2) < compared(search, [fit]).threshold + parameters * log(n)


def _without_one(
    search: Search, fit: CandidateFit, names: Sequence[str], fits: list[CandidateFit], removed: float
) -> CandidateFit | None:
    """Leave out an effect without which hardly more is left, a few at a time being tried; None where there is none.

    Args:
        search: The search.
        fit: The fit.
        names: The effects that are tried, the most doubtful first.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    for begin in range(0, len(names), TRIED):
        tried = names[begin : begin + TRIED]
        without = search.parallel("effects left out", partial(search.without, fit), tried, needed=TRIED)
        fits += without
        comparison = compared(search, best_of_each(fits))
        needless = [rest for rest in without if not worth(search, comparison, rest, fit, removed)]
        if needless:
            return min(needless, key=lambda rest: rest.chi2)
    return None


def _without_needless(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out the effects that are not worth their parameters by linear theory, but the best one.

    Of effects at the same motor that do much the same, such as Coulomb and viscous friction, each seems needless beside
    the others. So of those that torques show one at a motor is left out at a time, unless the time is over. Behind
    springs all go at once and compete again later: friction may drown there in the error of a spring, and one of its
    terms would stand for that. Where numbers of the model go far out of tolerance without several further effects, each
    is tried alone: one that is needed does not keep the others.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    kept: set[str] = set()
    alone = False
    while needless := [name for name in _needless(search, fit, removed) if name not in kept]:
        tried = needless[:1] if alone else needless
        fits.append(search.without(fit, *tried))
        further = set(tried) - search.shown_by_torques(fit)
        measured = search.from_torques
        if further and measured and _needed(search, fit, fits[-1], removed):
            # linear theory does not see what numbers of the model take over far from their tolerance, nor without which
            kept |= further if len(further) == 1 else set()
            alone = len(further) > 1 or alone
            continue
        fit = fits[-1]
        if _all_at_once(search) and not alone:
            break
    return fit


def one_by_one(search: Search, fit: CandidateFit, fits: list[CandidateFit], most: float = float("inf")) -> CandidateFit:
    """Leave out the effects of a measured log that are not worth their parameters, each after a fit without it.

    Linear theory proposes them, the one that seems least needed first. Effects that torques show are left out where
    their size is not clear; of all others a fit decides. A quick one does where it leaves hardly more than with the
    effect, as a fit to the end leaves no more than that; only one that leaves much more is carried to its end. So is
    what is left before further effects are judged, where linear theory sees that it is no minimum yet.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        most: Sum of squares from which no more is left out, as the result is of no use.
    """
    removed, kept = search.settings.search.removed_of_all, set[str]()
    while len(fit.hypothesis) > 1 and fit.chi2 <= most and not search.deadline.stops():
        needless = [name for name in _needless(search, fit, removed) if name not in kept]
        if not needless:
            break
        fits.append(search.without(fit, needless[0]))
        if needless[0] not in search.shown_by_torques(fit) and _missed(search, fit, fits[-1], removed):
            fits.append(search.completed(fits[-1]))
            if _missed(search, fit, fits[-1], removed):
                kept.add(needless[0])
                continue
        elif search.surroundings(fits[-1]).fall > max(search.settings.fit.enough, search.data.negligible):
            fits.append(search.completed(fits[-1]))
        fit = fits[-1]
    return fit


def _needed(search: Search, fit: CandidateFit, rest: CandidateFit, removed: float) -> bool:
    """Return whether effects are worth more than linear theory sees, or keep numbers of the model within tolerance."""
    return strains(search, compared(search, [rest]), fit, rest) or _missed(search, fit, rest, removed)


def _missed(search: Search, fit: CandidateFit, rest: CandidateFit, removed: float) -> bool:
    """Return whether the effects of a fit are worth more than those of another one that lacks some of them."""
    return worth(search, compared(search, [rest, fit]), rest, fit, removed)


def _needless(search: Search, fit: CandidateFit, removed: float) -> list[str]:
    """List effects that are not worth their parameters by linear theory, the least missed first.

    While there is time it is one of each motor.

    Effects that torques show are worth it where their size is clearly not zero: at a joint that moves little or carries
    little they remove a small part of the gap of all joints, and are as real as at the others. A size that changes
    nothing, such as a small delay of commands whose servo is at its limit, has no deviation and is not clear.
    Where a further effect at the same motor is not worth it either, that one goes first: beside friction by the load,
    which removes little, Coulomb friction is not clear, and left out first it could not come back. Of the
    effects of a servo the least clear one goes first: at a wrist without weight its inertia, stiffness and viscous
    friction may have any common factor, and without the one that is wrong the others would be clear instead.

    Args:
        search: The search.
        fit: The fit.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    surroundings, n, comparison = search.surroundings(fit), search.data.n_values, compared(search, [fit])
    every, without = surroundings.least, [rest.least for rest in search.removals(fit, surroundings)]
    sizes = parameters_of(fit, search.data) if search.torques_decide else [{} for _ in fit.hypothesis]
    shown = search.shown_by_torques(fit)
    needless: list[tuple[float, Candidate]] = []
    clear_by: dict[str, float] = {}
    for candidate, least, parameters in zip(fit.hypothesis, without, sizes, strict=True):
        cheaper = least * n ** (-len(candidate.free) / n)  # of the same score as with the parameters of the effect
        before, after = replace(fit, chi2=cheaper), replace(fit, chi2=every)
        if candidate.name in shown:
            clear, tolerated = search.settings.search.clear_in_torques, _tolerated(search, candidate)
            nothing = {one.name: _nothing(search, candidate, one) for one in candidate.free}
            if search.data.record.command is not None:
                clear_by[candidate.name] = clearness(parameters.values())
            worth_it = any(
                abs(size.value) > max(clear * hypot(size.std, tolerated), nothing[name])
                for name, size in parameters.items()
                if size.determined and (name == "mass" or candidate.effect is not ToolLoad)
            )
        else:
            worth_it = worth(search, comparison, before, after, removed)
        if least < max(without) and not worth_it:
            needless.append((least, candidate))
    least_first = [one for _, one in sorted(needless, key=lambda pair: pair[0])]
    if _all_at_once(search):
        return [one.name for one in least_first]
    ordered = least_first[::-1]  # of those of a location the last one counts
    first = {one.location: one.name for one in sorted(ordered, key=lambda one: -clear_by.get(one.name, 0.0))}
    further = {one.location: one.name for one in ordered if one.name not in shown}
    kept = (first | further).values()
    return [one.name for one in least_first if one.name in kept]


def _tolerated(search: Search, candidate: Candidate) -> float:
    """Return the tolerance of the numbers of the model that a relative error changes [1]; 0 of other effects.

    An error of about the tolerance is none: the number deviates within it.
    """
    if not issubclass(candidate.effect, AbstractRelativeError):
        return 0.0
    changed = candidate.effect().numbers(search.null.model.robot, candidate.location)
    return search.null.fit.predictor.tolerance.largest(changed)


def _nothing(search: Search, candidate: Candidate, free: FreeParameter) -> float:
    """Return the size up to which an effect that torques show is none, however clear it is [unit of its size].

    It is the torque that counts as no gap, of a constant torque at a motor, and the lightest load. The search for
    rotors goes from those of hobby servos to those of large arms, so that the inertia of the bodies tells which are
    none.
    """
    data, robot, least = search.data, search.null.model.robot, NOTHING * free.high
    if candidate.effect is ToolLoad:
        return max(search.settings.torque_start.lightest_load * moved_mass(robot), least)
    if candidate.effect is RotorInertia:
        return NOTHING * inertias_of_bodies(data.record, robot)[candidate.location]
    if candidate.effect is not TorqueBias:
        return least
    tolerated = data.measurement.tolerated_torque(data.record)[robot.joint_names.index(candidate.location)]
    return max(float(tolerated), least)


def _all_at_once(search: Search) -> bool:
    """Return whether effects that seem needless are left out together: no torques show them, or no time is left."""
    robot = search.null.model.robot
    return not search.torques_decide or robot.n_coordinates > robot.n_motors or search.deadline.stops()


def with_asymmetry(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Free the asymmetry of friction that torques show, and keep it where it is clear.

    Args:
        search: The search.
        fit: The effects that torques show, each with its size alone, and further ones.
        fits: All fits so far; a new one is appended.
    """
    whole = {candidate.name: candidate for candidate in search.candidates()}
    every = tuple(whole.get(candidate.name, candidate) for candidate in fit.hypothesis)
    if not any(_uneven(candidate) for candidate in every):
        return fit
    found = parameters_of(search.reshaped(fit, every), search.data)
    clear = search.settings.search.clear_asymmetry
    kept = tuple(
        wide if _uneven(wide) and abs(sizes[ASYMMETRY].value) > clear * sizes[ASYMMETRY].std else narrow
        for wide, narrow, sizes in zip(every, fit.hypothesis, found, strict=True)
    )
    if kept == fit.hypothesis:
        return fit
    fits.append(search.reshaped(fit, kept))
    return fits[-1]


def with_dropped(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Add the effects of the torques that were left out, then asymmetry, and keep what is clear now.

    Friction drowned in what another effect leaves, such as that of a wrong spring, shows once that effect is found.
    Friction whose mean is nominal may have an asymmetry that another effect imitates, which is needless then. One that
    was exchanged for what looks alike in torques, such as a constant torque for a wrong zero, was not left out.

    Args:
        search: The search.
        fit: An explanation with further effects than the torques show.
        fits: All fits so far; new ones are appended.
    """
    left_out = [candidate for candidate in search.base.hypothesis if candidate.name not in fit.names]
    dropped = [one for one in left_out if not any(alike(one, other) for other in fit.hypothesis)]
    directions = search.directions(dropped, fit)
    if not directions or search.deadline.stops():
        return fit
    additions = search.additions(directions, fit, search.surroundings(fit))
    fits.append(search.together(fit, additions))
    return reduced(search, with_asymmetry(search, fits[-1], fits), fits, search.settings.search.removed_by_step)


def with_dropped_again(
    search: Search, before: CandidateFit, chosen: CandidateFit, fits: list[CandidateFit]
) -> CandidateFit:
    """Judge the effects of the torques that were left out once more, beside those that were found since.

    Beside what was missing before, their sizes were not clear. None comes back alone: of Coulomb and viscous friction
    at a motor each promises little without the other one, and a law that stood for both may be in their place.

    Args:
        search: The search.
        before: The explanation when they were judged last.
        chosen: The explanation now.
        fits: All fits so far; new ones are appended.
    """
    if not search.torques_decide or chosen.names <= before.names:
        return chosen
    again = with_dropped(search, chosen, fits)
    if again.names == chosen.names:
        return chosen
    fits.append(search.completed(again))
    return fits[-1]


def without_unclear(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out effects of a simulated log whose size is not clear, where noise alone is left without them.

    Of some hundred candidates, a few gain more than their parameters cost by chance, or from a millionth of the gap
    that the form of large effects leaves: beside a gap of 1e7 nats a spring that bends by 2e-5 of its stiffness gained
    25. What its deviation says, with errors of form, is that it may be zero.

    Args:
        search: The search.
        fit: The explanation, at its end.
        fits: All fits so far; new ones are appended.
    """
    comparison, needed = compared(search, [fit]), set[str]()
    if not search.premises.library_is_complete or more_than_chance(comparison, fit):
        return fit
    while len(fit.hypothesis) > 1 and not search.deadline.stops_finishing():
        clear_by = {name: clear for name, clear in _clear_by(search, fit).items() if name not in needed}
        least = min(clear_by, key=clear_by.__getitem__, default="")
        if not least or clear_by[least] >= search.settings.search.clear:
            break
        fits.append(search.completed(search.without(fit, least)))
        if more_than_chance(comparison, fits[-1]):
            needed.add(least)
        else:
            fit = fits[-1]
    return fit


def unclear(search: Search, fit: CandidateFit, least: float) -> list[str]:
    """Return the effects of a fit of which no size, with errors of form, is clearly not zero.

    Args:
        search: The search.
        fit: The fit.
        least: Size over its standard deviation from which it is clear [1].
    """
    return [name for name, clear in _clear_by(search, fit).items() if clear < least]


def _clear_by(search: Search, fit: CandidateFit) -> dict[str, float]:
    """Return by how many standard deviations, with errors of form, the size of each effect of a fit is not zero [1]."""
    found = zip(fit.hypothesis, parameters_of(fit, search.data, search.settings.ranking), strict=True)
    return {one.name: clearness(sizes[free.name] for free in sizes_of(one)) for one, sizes in found}


def _uneven(candidate: Candidate) -> bool:
    return any(free.name == ASYMMETRY for free in candidate.free)
