"""The most probable explanation of a measured log among those that the held-out log does not refute."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.decision import on_held_out, rivals_of
from flexros.gap.held_out.closed_share import NOTHING, share_between
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.one_sample import surely_worse

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations


def most_probable(
    search: Search, explanations: Explanations, held: FitData, elsewhere: Collection[CandidateFit] = ()
) -> Explanations:
    """Choose the most probable explanation of a measured log among those that the held-out log does not refute.

    A rival that predicts the held-out log worse than the chosen explanation by more than chance is none: the fitted log
    alone is for it. Another one that is more probable takes the place of the chosen one, so that the patch holds what
    the answer calls most probable.

    Args:
        search: The search.
        explanations: All fits, and the chosen one.
        held: The held-out log.
        elsewhere: Explanations that lead with other tolerances, which are rivals whatever their probability.
    """
    if search.premises.library_is_complete:
        return explanations
    while rivals := [fit for fit in rivals_of(explanations, search.settings.ranking, elsewhere) if fit.hypothesis]:
        chosen, probability = explanations.chosen, dict(zip(explanations.rivals, explanations.probabilities))
        gone = [fit for fit in rivals if _refuted(search, fit, explanations, held)]
        best = max((fit for fit in (chosen, *rivals) if fit not in gone), key=probability.__getitem__)
        richer = [fit for fit in explanations.rivals if len(fit.hypothesis) > len(best.hypothesis)]
        explanations = _without(explanations, [*gone, *richer])
        if best is chosen:
            break
        explanations = _with_chosen(explanations, best, search.completed(best))
    return explanations


def _refuted(search: Search, fit: CandidateFit, explanations: Explanations, held: FitData) -> bool:
    """Return whether a log is predicted worse than by the chosen explanation, by more than chance at either horizon.

    Of two that predict nearly the same, every block of a log may be for one by next to nothing. So it counts one sample
    ahead where the likelihoods differ by more than the factor within which two are rivals, and 0.1 s ahead from a share
    of the gap that is written as more than nothing.
    """
    chosen = explanations.chosen
    rise = on_held_out(fit, held).chi2 / on_held_out(chosen, held).chi2
    if held.n_values * np.log(rise) > 2 * np.log(search.settings.ranking.rival) and surely_worse(fit, chosen, held):
        return True
    before, more, less = (errors_ahead(one, held) for one in (explanations.null, fit, chosen))
    share = share_between(before, more, less, held.record.sample_time)
    return share is not None and share.value >= NOTHING and share.interval[0] > 0


def _without(explanations: Explanations, gone: Collection[CandidateFit]) -> Explanations:
    """Leave out rivals; the others have the same odds."""
    stays = np.array([fit not in gone for fit in explanations.rivals])
    rivals = tuple(fit for fit, one in zip(explanations.rivals, stays, strict=True) if one)
    left = explanations.probabilities[stays]
    return replace(explanations, rivals=rivals, probabilities=left / left.sum())


def _with_chosen(explanations: Explanations, rival: CandidateFit, finished: CandidateFit) -> Explanations:
    """Choose a rival, whose fit is finished now."""
    comparison = explanations.comparison
    fits, rivals = (
        tuple(finished if fit is rival else fit for fit in among) for among in (comparison.fits, explanations.rivals)
    )
    return replace(explanations, comparison=replace(comparison, fits=fits), chosen=finished, rivals=rivals)
