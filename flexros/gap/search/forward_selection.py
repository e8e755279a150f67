"""Forward selection: single effects, then further ones for as long as they remove what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.search.model_probability import ModelComparison, compare

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.search.candidate_fits import Search


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

    Args:
        search: The log, the nominal model fitted to it and the settings.

    Returns:
        All fits and the chosen explanation.
    """
    settings = search.settings.search
    singles = unique(search.singles((*search.candidates(), *search.harmonics(search.null.fit))))
    comparison = _compare(search, singles)
    if not comparison.detected:
        return _explanations(comparison, search.null.fit, detected=False)
    level = comparison.ranked(singles)
    chosen, fits = level[0], list(singles)
    while len(chosen.hypothesis) < settings.most_effects and _incomplete(search, comparison, chosen):
        level = unique(search.extended(level[: settings.extended]))
        if not level:
            break
        fits += level
        comparison = _compare(search, unique(fits))
        level = comparison.ranked(level)
        if not _worth(search, comparison, chosen, level[0]):
            break
        revised = _backward(search, level[0], fits)
        fits += revised
        comparison = _compare(search, unique(fits))
        level = comparison.ranked(unique([*level, *revised]))
        chosen = level[0]
    return _pruned(search, _explanations(comparison, chosen, detected=True))


def _backward(search: Search, best: CandidateFit, fits: list[CandidateFit]) -> list[CandidateFit]:
    """Remove the effect that was found first, and extend the rest by others."""
    rest = names_of(best.hypothesis[1:])
    without = [fit for fit in fits if fit.names == rest]
    return search.extended([min(without, key=lambda fit: fit.chi2)]) if without else []


def _pruned(search: Search, explanations: Explanations) -> Explanations:
    """Prune the parameters of all likely explanations, so that none of them has a handicap."""
    likely = [
        fit
        for fit, probability in zip(explanations.rivals, explanations.probabilities)
        if probability > search.settings.ranking.likely or fit is explanations.chosen
    ]
    pruned = {fit: search.pruned(fit) for fit in likely}
    comparison = _compare(search, [pruned.get(fit, fit) for fit in explanations.comparison.fits])
    return _explanations(comparison, pruned[explanations.chosen], detected=True)


def _incomplete(search: Search, comparison: ModelComparison, chosen: CandidateFit) -> bool:
    """Return whether an explanation leaves more than noise or moves parameters beyond tolerance.

    The floor of a real machine is a matter of tolerance, so that its explanations always leave something.
    """
    return comparison.significant(chosen) or comparison.beyond_tolerance(chosen) or search.data.record.imported


def _worth(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Return whether one more effect removes a good part of the remaining gap, or of the prior penalty.

    On a real machine, where the floor is a matter of tolerance, it must remove a good part of all.
    """
    settings = search.settings.search
    if comparison.score(after) - comparison.score(before) < comparison.threshold:
        return False
    if search.data.record.imported:
        return comparison.level(after) < (1 - settings.removed_of_all) * comparison.level(before)
    relieved = after.prior_penalty < (1 - settings.removed) * before.prior_penalty
    if comparison.beyond_tolerance(before) and relieved:
        return True
    return comparison.removed(before, after) >= settings.removed


def _compare(search: Search, fits: Sequence[CandidateFit]) -> ModelComparison:
    return compare(search.data, search.null.fit, fits, search.distance, search.settings.ranking)


def unique(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Keep the best fit of every set of effects, the best first."""
    best: dict[frozenset[str], CandidateFit] = {}
    for fit in fits:
        if fit.names not in best or fit.chi2 < best[fit.names].chi2:
            best[fit.names] = fit
    return sorted(best.values(), key=lambda fit: fit.chi2)


def _explanations(comparison: ModelComparison, chosen: CandidateFit, *, detected: bool) -> Explanations:
    """Distribute probability over all explanations with no more effects than the chosen one."""
    most = max(1, len(chosen.hypothesis))
    rivals = [comparison.null, *(fit for fit in comparison.fits if len(fit.hypothesis) <= most)]
    probabilities = comparison.probabilities(rivals)
    order = np.argsort(-probabilities, kind="stable")
    return Explanations(comparison, chosen, tuple(rivals[index] for index in order), probabilities[order], detected)
