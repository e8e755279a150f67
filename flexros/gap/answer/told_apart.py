"""Explanations of a measured log within its floor, which the held-out log tells apart."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.decision import on_held_out
from flexros.gap.fit.candidate_fit import best_of_each
from flexros.gap.fit.limits import at_limits
from flexros.gap.held_out.closed_share import share_between
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.search.worth import compared

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.model_probability import ModelComparison

RIVALS = 3
"""Other explanations that are tried, those that gain most in the fitted log less what they cost [1] (chosen)."""


def told_apart(search: Search, chosen: CandidateFit, fits: Sequence[CandidateFit], held: FitData) -> CandidateFit:
    """Add to an explanation of a measured log within its floor what both logs are for.

    Within the tolerance of torques the fitted log does not count for an effect against what makes up for it there:
    friction that falls with speed against Coulomb friction, a gain of a servo against its damping and a rotor. Another
    motion does not confirm what makes up. Fits with further effects than the chosen ones are there from the search. One
    must leave less of the fitted log by more than its parameters cost, and remove as much of what the chosen one leaves
    of the held-out log as an effect must elsewhere, by more than chance. So must each of its further effects beside the
    others.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits.
        held: The held-out log.
    """
    if search.premises.library_is_complete or search.deadline.stops():
        return chosen
    comparison = compared(search, best_of_each([*fits, chosen]))
    if comparison.level(chosen) > search.settings.ranking.floors:
        return chosen
    gain = partial(_gain, search, comparison, chosen)
    more = [fit for fit in comparison.fits if fit.names > chosen.names]
    better = sorted((fit for fit in more if gain(fit) > comparison.threshold), key=gain, reverse=True)
    ahead = errors_ahead(chosen, held)

    def confirmed_by(rest: CandidateFit, fit: CandidateFit) -> bool:
        share = share_between(ahead, errors_ahead(rest, held), errors_ahead(fit, held), held.record.sample_time)
        if share is None or share.value < least or share.interval[0] <= 0:
            return False
        return on_held_out(fit, held).chi2 <= on_held_out(rest, held).chi2

    least = search.settings.search.removed_of_all
    for fit in better[:RIVALS]:
        whole = search.completed(fit)
        if not confirmed_by(chosen, whole):
            continue
        names = sorted(whole.names - chosen.names)
        while names and not search.deadline.stops():
            rests = search.parallel("effects on held-out data", partial(_without, search, whole), names)
            needless = [rest for rest in rests if not confirmed_by(rest, whole)]
            if not needless:
                break
            whole = min(needless, key=lambda rest: rest.chi2)
            names = sorted(whole.names - chosen.names)
        if names and not at_limits(whole):
            return whole
    return chosen


def _without(search: Search, fit: CandidateFit, name: str) -> CandidateFit:
    return search.completed(search.without(fit, name))


def _gain(search: Search, comparison: ModelComparison, before: CandidateFit, after: CandidateFit) -> float:
    """Return the gain of a fit over another one less the cost of its parameters, wherever the floor is [1]."""
    n, cost = search.data.n_values, comparison.penalty(after) - comparison.penalty(before)
    return float(n * np.log(before.chi2 / after.chi2)) - cost
