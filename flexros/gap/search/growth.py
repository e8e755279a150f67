"""Growth of an explanation: candidates added, needless ones left out, wrong ones exchanged, and again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.limits import at_limits
from flexros.gap.search.bristles import with_bristles
from flexros.gap.search.elimination.reduce import reduced
from flexros.gap.search.exchange import corrected, exchanged
from flexros.gap.search.fits.further import (
    draws_numbers,
    fitted_with,
    from_nominal_numbers,
    with_constant_torques,
    with_usual,
)
from flexros.gap.search.periodic.overtones import with_overtones
from flexros.gap.search.regrouping import regrouped
from flexros.gap.search.worth import (
    compared,
    floor_is_uncertain,
    gap_of_laws,
    in_vain,
    incomplete,
    more_than_chance,
    simple_first,
    worth,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.search.fits.additions import Addition
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison

TWIN = 1.05
"""Gain of two candidates together, over the larger of theirs alone, up to which they do the same [1] (chosen)."""


def extended(
    search: Search,
    chosen: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
    *,
    again: bool = False,
) -> CandidateFit:
    """Add effects to an explanation for as long as they remove what is left.

    Args:
        search: The search.
        chosen: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
        again: Whether the search goes on from an explanation that it has already tidied up.
    """
    settings = search.settings.search
    seen, circles = {chosen.names}, False
    for number in range(settings.rounds_after_torques if search.torques_decide else settings.rounds):
        further = settings.removed_by_further if search.torques_decide and (number or again) else 0.0
        if further and any(one.widened(name) for one, name in at_limits(chosen)):
            break  # a search that is widened removes what others would imitate
        chosen = with_constant_torques(search, chosen, fits)
        chosen = with_bristles(search, with_overtones(search, chosen, fits), fits)
        comparison = compared(search, best_of_each(fits))
        if not (incomplete(search, comparison, chosen) or _may_hide(search, comparison)):
            break
        if len(chosen.hypothesis) >= settings.most_effects or search.deadline.stops():
            break
        quick = not chosen.converged or len(chosen.deviations)  # with the tolerance slopes of the nominal model
        if quick and search.premises.library_is_complete:
            chosen = search.completed(chosen)  # what a fit in a long valley leaves is no effect that is missing
            fits.append(chosen)
        grown = None if number or again else with_usual(search, chosen, fits)
        grown = grown or (None if circles else with_more(search, chosen, directions, fits, further))
        if further and not (grown and _lowered(search, chosen, grown) > further):
            break
        least = _removed(search, chosen, settings.removed_by_step)
        if grown is None or not worth(search, compared(search, best_of_each(fits)), chosen, grown, least):
            grown = from_nominal_numbers(search, chosen, fits)
        comparison = compared(search, best_of_each(fits))
        if grown is None or not worth(search, comparison, chosen, grown, least):
            break
        if in_vain(search, chosen) and _still_in_vain(search, comparison, chosen, grown):
            break
        before, chosen = chosen, reduced(search, grown, fits, _removed(search, grown, settings.removed_by_step))
        other = chosen
        comparison = compared(search, best_of_each(fits))
        if incomplete(search, comparison, chosen):  # else nothing is imitated; the end looks again
            other = corrected(search, chosen, directions, fits)
        if other is not chosen:
            chosen = reduced(search, other, fits, _removed(search, other, settings.removed_by_step))
        again_found = chosen.names == before.names or chosen.names in seen
        if again_found and (circles or not draws_numbers(search, chosen)):
            break  # what a step adds, the next ones leave out again: the search would go round in a circle
        circles = again_found  # around the nominal numbers others may show
        seen.add(chosen.names)
    return chosen


def _lowered(search: Search, before: CandidateFit, after: CandidateFit) -> float:
    """Return the share of what a fit leaves above the floor that another one removes [1]."""
    left = before.chi2 - search.data.n_values
    return (before.chi2 - after.chi2) / left if left > 0 else 0.0


def _may_hide(search: Search, comparison: ModelComparison) -> bool:
    """Return whether effects may be missing although no more than noise is left, and show best in this log.

    A log that is tied more loosely next shows them better, and tells candidates apart that are the same here: a gain of
    torques and the weight of another body were added beside a limit of torques.
    """
    loosest = search.resumed or not search.data.torque_noise > search.data.least_torque_noise
    return loosest and floor_is_uncertain(comparison)


def _still_in_vain(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether a step of a resumed search removes less of what it leaves above noise than an effect must.

    What was within noise before is of few effects, which a step of several finds together. Where it removes less, the
    errors of form of the effects found before are what is left, and candidates imitate them without an end.
    """
    noise = 1.0 if search.left_before is None else min(search.left_before, 1.0)
    left, removed = comparison.level(before) - noise, comparison.level(before) - comparison.level(after)
    return removed < search.settings.search.removed * left


def tidied(
    search: Search, chosen: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Fit an explanation to the end, leave out what is needless, and exchange effects; arguments as for `extended`."""
    removed = search.settings.search.removed
    fits.append(search.completed(chosen))
    chosen = reduced(search, fits[-1], fits, _removed(search, fits[-1], removed))
    for step in (regrouped, exchanged):  # sets first: exchanges of single effects of a wrong set take long
        other = step(search, chosen, directions, fits)
        if other.names != chosen.names:  # what made up for an effect of wrong form is needless now
            other = reduced(search, other, fits, _removed(search, other, removed))
        chosen = other
    return chosen


def resumed(
    search: Search,
    before: CandidateFit,
    chosen: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
) -> CandidateFit:
    """Add further effects to an explanation in which effects were exchanged, or ended at limits of their search.

    An effect that imitates others by a value at its limit is no finding: without it, those others can be added. In a
    measured log, not every effect of which is of the library, the search goes on where the exchange removed as much of
    what was left as a further effect must: beside friction that slides at once, where it yields before, a ripple and
    the payload of an arm with springs did not show.

    Args:
        search: The search.
        before: The explanation as the search left it.
        chosen: What became of it.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    settings, rounds = search.settings.search, search.settings.search.resumed
    if not search.premises.library_is_complete:
        rounds = int(_lowered(search, before, chosen) > settings.removed_by_further)
    for _ in range(rounds):
        if search.deadline.stops():
            break
        valid = search.within_limits(chosen)
        changed = bool(valid.names - before.names) or valid.predictor.n_effect != chosen.predictor.n_effect
        if not changed or not valid.hypothesis:
            break
        grown = extended(search, valid, directions, fits, again=True)
        if grown.names == valid.names:
            break
        done = tidied(search, grown, directions, fits)
        comparison = compared(search, [valid, done])
        if comparison.score(done) < comparison.score(valid) + comparison.threshold:
            break
        before, chosen = grown, done
    return chosen


def _removed(search: Search, fit: CandidateFit, usual: float) -> float:
    """Return the share of the remaining gap that every effect of an explanation must remove [1].

    A little more than noise that a fit of a simulated log leaves, within the model-form error of the whole gap, may be
    no missing effect: candidates that take up a part of it, with several parameters, imitate the form.

    Args:
        search: The search.
        fit: The explanation.
        usual: The share where more is left, or noise alone [1].
    """
    n, settings = search.data.n_values, search.settings.search
    comparison = compared(search, [fit])
    if search.torques_decide or not fit.chi2 - n < settings.little * n or not more_than_chance(comparison, fit):
        return usual
    form = search.settings.ranking.shaped_form * gap_of_laws(search, comparison, fit)
    return settings.removed_of_little if fit.chi2 - n < form * n else usual


def with_more(
    search: Search,
    fit: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
    further: float = 0.0,
    known: Sequence[CandidateFit] = (),
    least: float | None = None,
) -> CandidateFit | None:
    """Add candidates to a fit: several whose gains add up, or one of the best.

    Several begin with the sizes that they have together by linear theory. In a simulated log each further one gains
    more than its parameters cost: beside one that is missing, imitations of noise made the group not worth it. Where
    the fit of several is not worth it, that is no sign that nothing is missing: then each of the best ones that differ
    is tried alone as well.

    Args:
        search: The search.
        fit: The fit.
        directions: All candidates but those of harmonics, which follow from the fit.
        fits: All fits so far; new ones are appended.
        further: Share of what is left that the candidates must remove together after those that torques show [1].
        known: Earlier fits, of which one with the same effects is taken in place of a new one of several candidates.
        least: Share of what is left that each candidate must remove beside those that torques show [1], by default that
            of every effect; half of it must be predicted, as linear theory underestimates some.

    Returns:
        The best of the new fits; None where no candidate is left.
    """
    settings, surroundings = search.settings.search, search.surroundings(fit)
    additions = _additions(search, fit, directions)
    if not additions:
        return None
    group = _independent(search, fit, additions)
    if search.torques_decide:
        rest = fit.chi2 - search.data.n_values
        least = settings.removed_of_all if least is None else least
        group = [addition for addition in group if addition.gain > settings.hopeful * least * rest]
        if not group or sum(addition.gain for addition in group) < settings.hopeful * further * rest:
            return None
    else:
        least = settings.hopeful * _least_gain(search, fit)
        if sum(addition.gain for addition in group) < least:
            return None
        additions = [addition for addition in additions if addition.gain > least]
        cost = float(np.log(search.data.n_values))  # of a parameter, by the information criterion
        group = [one for one in group if one is group[0] or one.gain > cost * len(one.candidate.free)]
    if len(group) > 1 and not search.torques_decide:
        sizes = surroundings.sizes(np.stack([addition.change for addition in group], axis=-1))
        group = [addition.sized(size) for addition, size in zip(group, sizes, strict=True)]
    grown = (_known(fit, group, known) or fitted_with(search, fit, [group], fits)) if len(group) > 1 else None
    step = _removed(search, fit, settings.removed_by_step)

    def worth_it(one: CandidateFit) -> bool:
        enough = fit.chi2 - one.chi2 >= step * max(fit.chi2 - search.data.n_values, 0.0)
        return enough and worth(search, compared(search, best_of_each(fits)), fit, one, step)

    if grown is not None and (search.torques_decide or search.deadline.stops() or worth_it(grown)):
        return grown
    alone = fitted_with(search, fit, [[addition] for addition in _different(search, fit, additions)], fits)
    if grown is None or alone is None:
        return grown or alone
    return alone if alone.chi2 < grown.chi2 or worth_it(alone) else grown  # others of the group may hide its worth


def _least_gain(search: Search, fit: CandidateFit) -> float:
    """Return what an effect of a simulated log must lower the sum of squares by where hardly more than noise is left.

    Beyond noise nothing less than the model-form error counts, and of little more than noise a good part of it. Fits of
    less, of which linear theory promises many, took most of the time of two axes; where more is left, it says too
    little of laws whose sizes are far off, and none is left out.

    Args:
        search: The search.
        fit: The explanation.
    """
    n, comparison = search.data.n_values, compared(search, [fit])
    if more_than_chance(comparison, fit):
        return _removed(search, fit, 0.0) * (fit.chi2 - n)
    return max(search.settings.ranking.shaped_form * gap_of_laws(search, comparison, fit), 0.0) * n


def promises(search: Search, fit: CandidateFit, directions: Sequence[Directions], share: float) -> bool:
    """Return whether candidates that gain nearly as much together as alone promise to remove a share of what is left.

    Half of it is enough, as linear theory underestimates some.

    Args:
        search: The search.
        fit: The fit.
        directions: All candidates but those of harmonics, which follow from the fit.
        share: The share of what is above the floor [1].
    """
    group = _independent(search, fit, _additions(search, fit, directions))
    rest = fit.chi2 - search.data.n_values
    return sum(addition.gain for addition in group) >= search.settings.search.hopeful * share * rest


def _additions(search: Search, fit: CandidateFit, directions: Sequence[Directions]) -> list[Addition]:
    """List the candidates that may be added to a fit, the most promising first."""
    every = [*directions, *search.directions(search.harmonics(fit))]
    found = search.additions(every, fit, search.surroundings(fit))
    return simple_first(search, fit, found)[: search.settings.search.screened]


def _independent(search: Search, fit: CandidateFit, additions: Sequence[Addition]) -> list[Addition]:
    """Select candidates, each with its best order, that gain nearly as much together as alone."""
    settings = search.settings.search
    distinct = list({one.candidate.name: one for one in reversed(additions)}.values())[::-1]
    changes = np.stack([one.change for one in distinct], axis=-1) if distinct else np.empty((len(search.rows), 0))
    chosen = search.surroundings(fit).independent(changes, settings.grouped, settings.kept)
    return [distinct[index] for index in chosen]


def _different(search: Search, fit: CandidateFit, additions: Sequence[Addition]) -> list[Addition]:
    """Select the most promising candidates of which none promises what another one does.

    Three delays and lags of a servo are one candidate to linear theory, and hid friction that promised nearly as much.
    """
    around, most = search.surroundings(fit), search.settings.search.added
    chosen: list[Addition] = []
    for one in additions:
        twins = (
            around.least - around.left(np.stack([one.change, other.change], axis=-1)) < TWIN * max(one.gain, other.gain)
            for other in chosen
        )
        if not any(twins):
            chosen.append(one)
        if len(chosen) == most:
            break
    return chosen


def _known(fit: CandidateFit, group: Sequence[Addition], known: Sequence[CandidateFit]) -> CandidateFit | None:
    """Return the best of some fits that have the effects of a fit and of a group of candidates; None without one."""
    names = fit.names | {addition.candidate.name for addition in group}
    alike = [one for one in known if one.names == names and one.chi2 < fit.chi2]
    return min(alike, key=lambda one: one.chi2, default=None)
