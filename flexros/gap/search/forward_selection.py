"""Explaining a log: single effects, then more beside them for as long as they remove what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.search.model_probability import ModelComparison, evidence_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.scales import Scales
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.search.candidate_fits import Search

MOST_EFFECTS = 4
"""Most effects in one explanation (chosen)."""
FIRSTS = 3
"""Best explanations that a further effect is added to (chosen)."""
REMOVED = 0.4
"""Share of what is left that a further effect must remove; spurious ones remove up to 0.3 (development seeds)."""
REMOVED_OF_ALL = 0.3
"""Share of all that is left that a further effect must remove on a real machine [1] (chosen)."""
RIVAL = 3.0
"""A rival whose probability is within this factor makes the answer ambiguous [1] (the contract)."""
LIKELY = 0.01
"""Probability of an explanation from which its numbers and their errors are looked at with care [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class Explanations:
    """All that was fitted to a log, and what was chosen.

    Attributes:
        evidence: All fits, each hypothesis once.
        chosen: The explanation; "nothing" where no effect was detected.
        rivals: Fits with no more effects than the chosen one, and the nominal model, by probability.
        probabilities: Theirs, shape (n_rivals,).
        detected: Whether an effect was detected.
    """

    evidence: ModelComparison
    chosen: CandidateFit
    rivals: tuple[CandidateFit, ...]
    probabilities: FloatArray
    detected: bool

    @property
    def left(self) -> float:
        """Share of the gap that the chosen explanation leaves [1]; zero where what is left is not significant."""
        return self.evidence.left(self.chosen)


def explain(search: Search) -> Explanations:
    """Search a log for causes.

    Args:
        search: The log and what is needed to search it.

    Returns:
        All fits and the chosen explanation.
    """
    nothing = search.nothing()
    sizes = search.scales(nothing)
    singles = unique(search.singles(nothing, (*search.candidates(sizes), *search.waves(nothing))))
    evidence = _evidence(search, nothing, singles)
    if not evidence.detected:
        return _explanations(evidence, nothing, detected=False)
    level = evidence.ranked(singles)
    chosen, found = level[0], list(singles)
    while len(chosen.predictor.hypothesis) < MOST_EFFECTS and _left(search, evidence, chosen):
        level = unique(search.beside(level[:FIRSTS], nothing, sizes))
        if not level:
            break
        found += level
        evidence = _evidence(search, nothing, unique(found))
        level = evidence.ranked(level)
        if not _worth(search, evidence, chosen, level[0]):
            break
        again = _backward(search, level[0], found, nothing, sizes)
        found += again
        evidence = _evidence(search, nothing, unique(found))
        level = evidence.ranked(unique([*level, *again]))
        chosen = level[0]
    return _lean(search, _explanations(evidence, chosen, detected=True))


def _backward(
    search: Search, best: CandidateFit, found: list[CandidateFit], nothing: CandidateFit, sizes: Scales
) -> list[CandidateFit]:
    """Take what was found first out again, and look what else goes with the rest."""
    rest = names_of(best.predictor.hypothesis[1:])
    alone = [one for one in found if one.names == rest]
    return search.beside([min(alone, key=lambda one: one.chi2)], nothing, sizes) if alone else []


def _lean(search: Search, found: Explanations) -> Explanations:
    """Leave numbers that the log does not show out of all likely explanations, so that none of them has a handicap."""
    likely = [one for one, p in zip(found.rivals, found.probabilities) if p > LIKELY or one is found.chosen]
    leaner = {one: search.lean(one) for one in likely}
    fits = [leaner.get(one, one) for one in found.evidence.fits]
    evidence = _evidence(search, found.evidence.nothing, fits)
    return _explanations(evidence, leaner[found.chosen], detected=True)


def _left(search: Search, evidence: ModelComparison, chosen: CandidateFit) -> bool:
    """Tell whether an explanation leaves anything to explain; that of a real machine always does.

    Also one that takes more than the tolerances of the model to be true.
    """
    return evidence.significant(chosen) or evidence.strained(chosen) or search.data.record.imported


def _worth(search: Search, evidence: ModelComparison, before: CandidateFit, after: CandidateFit) -> bool:
    """Tell whether one more effect is worth it: it removes a good part of what is left, or of strained tolerances.

    On a real machine, where the floor is a matter of tolerance, it must remove a good part of all.
    """
    if evidence.score(after) - evidence.score(before) < evidence.least:
        return False
    if search.data.record.imported:
        return evidence.level(after) < (1 - REMOVED_OF_ALL) * evidence.level(before)
    relieved = evidence.strained(before) and after.price < (1 - REMOVED) * before.price
    return relieved or evidence.removed(before, after) >= REMOVED


def _evidence(search: Search, nothing: CandidateFit, fits: Sequence[CandidateFit]) -> ModelComparison:
    return evidence_of(search.data, nothing, fits, search.distance)


def unique(fits: list[CandidateFit]) -> list[CandidateFit]:
    """Keep the best fit of every set of effects, the best first."""
    best: dict[frozenset[str], CandidateFit] = {}
    for one in fits:
        if one.names not in best or one.chi2 < best[one.names].chi2:
            best[one.names] = one
    return sorted(best.values(), key=lambda one: one.chi2)


def _explanations(evidence: ModelComparison, chosen: CandidateFit, *, detected: bool) -> Explanations:
    """Distribute probability: over all explanations with as many effects as the chosen one, and simpler ones."""
    most = max(1, len(chosen.predictor.hypothesis))
    rivals = [one for one in evidence.fits if len(one.predictor.hypothesis) <= most]
    among = [evidence.nothing, *rivals]
    probabilities = evidence.probabilities(among)
    order = np.argsort(-probabilities, kind="stable")
    return Explanations(evidence, chosen, tuple(among[place] for place in order), probabilities[order], detected)
