"""Explaining a log: single effects, then more beside them for as long as they remove what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.evidence import DETECTED, Evidence

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit import Fit
    from flexros.gap.search import Search

MOST_EFFECTS = 4
"""Most effects in one explanation (chosen)."""
FIRSTS = 3
"""Best explanations that a further effect is added to (chosen)."""
REMOVED = 0.7
"""Share of what is left that a further effect must remove; spurious ones remove up to 0.3 (development seeds)."""
UNEXPLAINED = 0.1
"""Share of the gap that an explanation may leave before the cause counts as unknown [1] (the contract)."""
RIVAL = 3.0
"""A rival whose probability is within this factor makes the answer ambiguous [1] (the contract)."""


@dataclass(frozen=True, eq=False)
class Explanations:
    """All that was fitted to a log, and what was chosen.

    Attributes:
        evidence: All fits, each hypothesis once.
        chosen: The explanation; "nothing" where no effect was detected.
        probabilities: Of all fits and, last, of nothing, in the order of `rivals`, shape (n_rivals,).
        rivals: All fits by probability, the nominal model among them.
        detected: Whether an effect was detected.
    """

    evidence: Evidence
    chosen: Fit
    rivals: tuple[Fit, ...]
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
    sizes = search.yardsticks(nothing)
    singles = search.singles(nothing, search.suspects(nothing, sizes))
    evidence = _evidence(search, nothing, singles)
    if not evidence.detected:
        return _explanations(evidence, nothing, detected=False)
    chosen, level = singles[0], singles
    found = list(singles)
    while evidence.significant(chosen) and len(chosen.predictor.hypothesis) < MOST_EFFECTS:
        level = [new for first in level[:FIRSTS] for new in search.beside(first, sizes)]
        level = unique(level)
        found += level
        best = level[0]
        worth = evidence.score(best) - evidence.score(chosen)
        if worth < DETECTED or evidence.removed(chosen, best) < REMOVED:
            break
        chosen = best
    return _explanations(_evidence(search, nothing, unique(found)), chosen, detected=True)


def _evidence(search: Search, nothing: Fit, fits: Sequence[Fit]) -> Evidence:
    return Evidence(nothing, tuple(fits), search.data.n_values, search.data.measurement.floor_error)


def unique(fits: list[Fit]) -> list[Fit]:
    """Keep the best fit of every set of effects, the best first."""
    best: dict[frozenset[str], Fit] = {}
    for one in fits:
        key = frozenset(suspect.name for suspect in one.predictor.hypothesis)
        if key not in best or one.chi2 < best[key].chi2:
            best[key] = one
    return sorted(best.values(), key=lambda one: one.chi2)


def _explanations(evidence: Evidence, chosen: Fit, *, detected: bool) -> Explanations:
    """Distribute probability: over all explanations with as many effects as the chosen one, and simpler ones."""
    most = max(1, len(chosen.predictor.hypothesis))
    rivals = [one for one in evidence.fits if len(one.predictor.hypothesis) <= most]
    among = [evidence.nothing, *rivals]
    probabilities = evidence.probabilities(among)
    order = np.argsort(-probabilities, kind="stable")
    return Explanations(evidence, chosen, tuple(among[place] for place in order), probabilities[order], detected)
