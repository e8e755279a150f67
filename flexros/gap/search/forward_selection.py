"""Forward selection: single effects, then further ones for as long as they remove what is left."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.fit.estimates import parameters_of
from flexros.gap.search.curve_candidates import within_motion
from flexros.gap.search.curves import curves_of, in_place_of_laws, with_curves
from flexros.gap.search.worth import compared, incomplete, simple_first, simplest, worth

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.fit.screening import Directions, Surroundings
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.search.candidate_fits import Addition, Search
    from flexros.gap.search.model_probability import ModelComparison


ASYMMETRY = "asymmetry"
"""Parameter by which friction differs between the directions."""
PAIR = 2
"""Effects up to which every explanation with fewer of them is a rival [1]."""


@dataclass(frozen=True, eq=False)
class Explanations:
    """All fits of a log, and the chosen one.

    Attributes:
        comparison: All fits, each hypothesis once, compared.
        chosen: The explanation; the null fit where no effect was detected.
        rivals: Fits with no more effects than the chosen one, and the null fit, by probability.
        probabilities: Their probabilities [1], shape (n_rivals,).
        detected: Whether an effect was detected.
    """

    comparison: ModelComparison
    chosen: CandidateFit
    rivals: tuple[CandidateFit, ...]
    probabilities: FloatArray
    detected: bool

    @property
    def null(self) -> CandidateFit:
        """The fit of the nominal model."""
        return self.comparison.null

    @property
    def remainder(self) -> float:
        """Share of the gap that the chosen explanation leaves [1]; zero where what is left is not significant."""
        return self.comparison.remainder(self.chosen)


def explain(search: Search) -> Explanations:
    """Search a log for causes.

    Every effect alone, then forward selection: several candidates at a time whose gains add up, all fitted again
    together, and those that turn out to remove little left out again. What counts is the removal of an effect at the
    end, with all others in place: at the beginning each of many true effects removes only a small part of the gap.

    Args:
        search: The log, the nominal model fitted to it and the settings.

    Returns:
        All fits and the chosen explanation.
    """
    settings = search.settings.search
    null = search.null.fit
    directions = search.directions(search.candidates())
    if search.base is null:
        fits = unique(search.singles([*directions, *search.directions(search.harmonics(null))]))
    else:
        fits = [search.base]
    comparison = compared(search, fits)
    if not comparison.detected:
        return _explanations(search, comparison, null, detected=False)
    chosen = simplest(search, comparison, comparison.ranked(fits)[0], fits)
    if search.base is not null:
        chosen = _reduced(search, chosen, fits, settings.removed_by_step)
        chosen = _with_asymmetry(search, chosen, fits)
        dropped = [one for one in search.candidates() if one.name in search.base.names - chosen.names]
        directions += search.directions(dropped, chosen)  # beside another effect they may be needed
    first = chosen
    for _ in range(settings.rounds if search.base is null else settings.rounds_after_torques):
        if len(chosen.hypothesis) >= settings.most_effects or not incomplete(search, comparison, chosen):
            break
        if search.deadline.stops():
            break
        quick = not chosen.converged or len(chosen.deviations)  # with the tolerance slopes of the nominal model
        if quick and not search.data.record.imported:
            chosen = search.completed(chosen)  # what a fit in a long valley leaves is no effect that is missing
            fits.append(chosen)
        grown = _grown(search, chosen, directions, fits)
        comparison = compared(search, unique(fits))
        if grown is None or not worth(search, comparison, chosen, grown, settings.removed_by_step):
            break
        before, chosen = chosen, _reduced(search, grown, fits, settings.removed_by_step)
        if chosen.names == before.names:
            break
    if search.base is not null and chosen.names != first.names:
        chosen = _with_dropped(search, chosen, fits)
    if len(chosen.hypothesis) > 1:
        fits.append(search.completed(chosen))
        chosen = _reduced(search, fits[-1], fits, settings.removed)
        exchanged = _exchanged(search, chosen, directions, fits)
        if exchanged.names != chosen.names:  # what made up for an effect of wrong form is needless now
            exchanged = _reduced(search, exchanged, fits, settings.removed)
        chosen = exchanged
    elif search.deadline.over:
        chosen = search.completed(chosen)
        fits.append(chosen)
    curved = with_curves(search, chosen, directions, fits)
    if curved is not chosen:
        chosen = _beside_curves(search, first, curved, directions, fits)
    comparison = compared(search, unique(fits))
    (chosen,) = (fit for fit in comparison.fits if fit.names == chosen.names)
    return _pruned(search, _explanations(search, comparison, chosen, detected=True))


def _grown(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit | None:
    """Add candidates to a fit: several whose gains add up, or one of the best.

    Args:
        search: The search.
        fit: The fit.
        directions: All candidates but those of harmonics, which follow from the fit.
        fits: All fits so far; new ones are appended.

    Returns:
        The best of the new fits; None where no candidate is left.
    """
    settings, surroundings = search.settings.search, search.surroundings(fit)
    every = [*directions, *search.directions(search.harmonics(fit))]
    additions = simple_first(search, fit, search.additions(every, fit, surroundings))[: settings.screened]
    if not additions:
        return None
    changes = np.stack([addition.change for addition in additions], axis=-1)
    group = [additions[index] for index in surroundings.independent(changes, settings.grouped, settings.kept)]
    if search.base is not search.null.fit:
        rest = fit.chi2 - search.data.n_values
        group = [addition for addition in group if addition.gain > settings.hopeful * settings.removed_of_all * rest]
        if not group:
            return None
    trials = [group] if len(group) > 1 else [[addition] for addition in additions[: settings.added]]
    together = search.parallel("effects together", lambda trial: search.together(fit, trial), trials)
    grown = search.visible([search.with_visible(one) for one in together])
    fits += grown
    return grown[0] if grown else None


def _reduced(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out the effects without which hardly more is left, one after the other.

    Effects that are indispensable by linear theory are not tried. Without time for fits, and of the crowd of effects
    that torques show, all are left out at once that are needless by linear theory.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; new ones are appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    settings, n = search.settings.search, search.data.n_values
    if search.data.record.imported:
        removed = search.settings.search.removed_of_all
    certain = min(settings.indispensable, settings.certain * removed)
    while len(fit.hypothesis) > 1:
        if search.base is not search.null.fit or search.deadline.stops_finishing():
            return _without_needless(search, fit, fits, removed)
        surroundings = search.surroundings(fit)  # of some rows: they tell how much is lost, not how much is left
        lost = [max(rest.least - surroundings.least, 0.0) for rest in search.removals(fit, surroundings)]
        left = max(fit.chi2 - n, 0.0)
        doubtful = [one.name for one, rise in zip(fit.hypothesis, lost) if rise < certain * (rise + left) or rise == 0]
        without = search.parallel("effects left out", partial(search.without, fit), doubtful, needed=len(doubtful))
        fits += without
        comparison = compared(search, unique(fits))
        needless = [rest for rest in without if not worth(search, comparison, rest, fit, removed)]
        if not needless:
            break
        fit = min(needless, key=lambda rest: rest.chi2)
    return fit


def _beside_curves(
    search: Search,
    first: CandidateFit,
    curved: CandidateFit,
    directions: Sequence[Directions],
    fits: list[CandidateFit],
) -> CandidateFit:
    """Leave out the laws that imitated what curves explain now, and add those that were hidden behind it.

    Laws that were found without the curves may all be imitations of them. So the curves are also tried with the laws
    that the search began with, less those at their motors that they do not contain. Of two explanations of which one
    has all effects of the other, the larger one must be worth them.

    Args:
        search: The search.
        first: The explanation before further effects were added.
        curved: The explanation with curves.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    removed = search.settings.search.removed
    alternatives = [(curved, directions)]
    rest = in_place_of_laws(search, first, curved)
    curves = names_of(tuple(curves_of(curved.hypothesis)))
    if rest.names != curved.names - curves and not search.deadline.stops():
        other = with_curves(search, rest, directions, fits, curves)
        if other is not rest:
            alternatives.append((other, search.directions(search.candidates(), other)))
    found = []
    for fit, candidates in alternatives:
        small = _reduced(search, fit, fits, removed)
        for _ in range(search.settings.search.rounds):
            grown = None if search.deadline.stops() else _grown(search, small, candidates, [])
            if grown is None or not worth(search, compared(search, unique(fits)), small, grown, removed):
                break
            fits.append(search.completed(within_motion(search, grown)))
            before, small = small, _reduced(search, fits[-1], fits, removed)
            if small.names == before.names:
                break
        found.append(small)
    comparison = compared(search, unique(fits))
    best, *others = comparison.ranked(found)
    for fewer in others:
        if fewer.names < best.names and not worth(search, comparison, fewer, best, removed):
            best = fewer
    return best


def _without_needless(search: Search, fit: CandidateFit, fits: list[CandidateFit], removed: float) -> CandidateFit:
    """Leave out at once all effects that are not worth their parameters by linear theory, but the best one.

    Effects that torques show are worth it where their size is clearly not zero: at a joint that moves little or carries
    little they remove a small part of the gap of all joints, and are as real as at the others.

    Args:
        search: The search.
        fit: The fit.
        fits: All fits so far; a new one is appended.
        removed: Share of the remaining gap that every effect must remove [1].
    """
    surroundings, n, comparison = search.surroundings(fit), search.data.n_values, compared(search, [fit])
    every, without = surroundings.least, [rest.least for rest in search.removals(fit, surroundings)]
    sizes = parameters_of(fit, search.data) if search.base is not search.null.fit else [{} for _ in fit.hypothesis]
    needless = []
    for candidate, least, parameters in zip(fit.hypothesis, without, sizes, strict=True):
        cheaper = least * n ** (-len(candidate.free) / n)  # of the same score as with the parameters of the effect
        before, after = replace(fit, chi2=cheaper), replace(fit, chi2=every)
        if candidate.name in search.base.names:
            clear = search.settings.search.clear_in_torques
            worth_it = any(abs(size.value) > clear * size.std for size in parameters.values())
        else:
            worth_it = worth(search, comparison, before, after, removed)
        if least < max(without) and not worth_it:
            needless.append(candidate.name)
    if not needless:
        return fit
    fits.append(search.without(fit, *needless))
    return fits[-1]


def _with_asymmetry(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Free the asymmetry of friction that torques show, and keep it where it is clear.

    Args:
        search: The search.
        fit: The effects that torques show, each with its size alone.
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


def _with_dropped(search: Search, fit: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Add the effects of the torques that were left out, and keep those that are clear now.

    Friction drowned in what another effect leaves, such as that of a wrong spring, shows once that effect is found.

    Args:
        search: The search.
        fit: An explanation with further effects than the torques show.
        fits: All fits so far; new ones are appended.
    """
    dropped = [candidate for candidate in search.base.hypothesis if candidate.name not in fit.names]
    directions = search.directions(dropped, fit)
    if not directions or search.deadline.stops():
        return fit
    additions = search.additions(directions, fit, search.surroundings(fit))
    fits.append(search.together(fit, additions))
    return _reduced(search, fits[-1], fits, search.settings.search.removed_by_step)


def _uneven(candidate: Candidate) -> bool:
    return any(free.name == ASYMMETRY for free in candidate.free)


def _exchanged(
    search: Search, fit: CandidateFit, directions: Sequence[Directions], fits: list[CandidateFit]
) -> CandidateFit:
    """Exchange effects for candidates that may do the same, for as long as that improves the explanation.

    Args:
        search: The search.
        fit: The explanation.
        directions: All candidates but those of harmonics.
        fits: All fits so far; new ones are appended.
    """
    settings = search.settings.search
    for _ in range(settings.rounds if len(fit.hypothesis) > 1 else 0):
        if search.deadline.stops():
            break
        surroundings = search.surroundings(fit)
        pairs = [
            (candidate.name, addition)
            for candidate, rest in zip(fit.hypothesis, search.removals(fit, surroundings))
            if candidate.name not in search.base.names
            for addition in _replacements(search, fit, rest, directions)[: settings.added]
        ]
        plants = search.plants(fit, [addition.candidate for _, addition in pairs])
        exchange = partial(_exchange, search, fit, plants)
        fits += search.visible(search.parallel("effects exchanged", exchange, pairs))
        comparison = compared(search, unique(fits))
        level = [one for one in comparison.fits if len(one.hypothesis) == len(fit.hypothesis)]
        best = simplest(search, comparison, comparison.ranked(level)[0], level)
        if best.names == fit.names or best.chi2 > fit.chi2:
            break
        fit = search.completed(best)
        fits.append(fit)
    return fit


def _exchange(
    search: Search, fit: CandidateFit, plants: Mapping[Candidate, CompiledPlant], pair: tuple[str, Addition]
) -> CandidateFit:
    """Fit an explanation with one candidate in place of one of its own."""
    name, addition = pair
    return search.together(fit, [addition], without=name, plant=plants[addition.candidate], rival=fit.chi2)


def _replacements(
    search: Search, fit: CandidateFit, rest: Surroundings, directions: Sequence[Directions]
) -> list[Addition]:
    """List the candidates that may regain most of what is lost without an effect."""
    lost = rest.least - fit.chi2
    additions = search.additions(directions, fit, rest)
    return [addition for addition in additions if addition.gain > search.settings.search.regained * lost]


def _pruned(search: Search, explanations: Explanations) -> Explanations:
    """Prune the parameters of all likely explanations, so that none of them has a handicap."""
    likely = [
        fit
        for fit, probability in zip(explanations.rivals, explanations.probabilities)
        if probability > search.settings.ranking.likely or fit is explanations.chosen
    ]
    pruned = {fit: search.pruned(fit) for fit in likely}
    chosen = search.within_limits(pruned[explanations.chosen])
    fits = [pruned.get(fit, fit) for fit in explanations.comparison.fits if fit is not explanations.chosen]
    if chosen.predictor.n_effect < explanations.chosen.predictor.n_effect:  # without a parameter one may be needless
        chosen = _reduced(search, chosen, fits, search.settings.search.removed)
    if not chosen.hypothesis:
        return _explanations(search, compared(search, fits), search.null.fit, detected=False)
    comparison = compared(search, [*(fit for fit in fits if fit.names != chosen.names), chosen])
    return _explanations(search, comparison, chosen, detected=True)


def unique(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Keep the best fit of every set of effects, the best first."""
    best: dict[frozenset[str], CandidateFit] = {}
    for fit in fits:
        if fit.names not in best or fit.chi2 < best[fit.names].chi2:
            best[fit.names] = fit
    return sorted(best.values(), key=lambda fit: fit.chi2)


def _explanations(search: Search, comparison: ModelComparison, chosen: CandidateFit, *, detected: bool) -> Explanations:
    """Distribute probability over all explanations with no more effects than the chosen one."""
    most = max(1, len(chosen.hypothesis))
    small = [fit for fit in comparison.fits if len(fit.hypothesis) <= most]
    removed = search.settings.search.removed

    def rivals_with(fit: CandidateFit) -> bool:
        fewer = len(fit.hypothesis) < len(chosen.hypothesis)
        if most > PAIR and fewer and worth(search, comparison, fit, chosen, removed):
            return False  # the form error of the large effects of a crowd is no doubt about the small ones
        return simplest(search, comparison, fit, small) is fit

    rivals = [comparison.null, *filter(rivals_with, small)]
    probabilities = comparison.probabilities(rivals)
    order = np.argsort(-probabilities, kind="stable")
    return Explanations(comparison, chosen, tuple(rivals[index] for index in order), probabilities[order], detected)
