"""Errors of numbers of the model that are within their tolerance once an explanation of a measured log is complete."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.gap.fit.least_squares import fit as fit_candidate
from flexros.gap.fit.tolerance_takeover import takeover
from flexros.gap.search.model_probability import compare
from flexros.gap.search.worth import compared, worth

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.search.candidate_fits import Search


def without_tolerated(search: Search, chosen: CandidateFit, fits: list[CandidateFit]) -> CandidateFit:
    """Leave out errors of numbers of the model that their tolerances take up.

    The prior of tolerances weighs by what the first effects of a measured log leave, the misfit. Where the explanation
    leaves far less in the end, it weighs too much then, and the error of a number seems to be worth its parameter
    because the same deviation within tolerance costs that much. So each is compared with the deviations at the misfit
    that the explanation leaves.

    Args:
        search: The search.
        chosen: The explanation.
        fits: All fits so far; new ones are appended.
    """
    comparison = compared(search, [chosen])
    left = max(comparison.level(chosen), 1.0)
    if search.premises.floor_is_noise or search.data.misfit <= left:
        return chosen
    data, removed = replace(search.data, misfit=left), search.settings.search.removed_of_all
    settings = search.settings.fit

    def fitted(predictor: Predictor, start: FloatArray) -> CandidateFit:
        enough, most = max(settings.exactly, data.negligible), settings.final_iterations
        stop = search.deadline.of_fit(finishing=True)
        return fit_candidate(predictor, data, start, most, enough=enough, settings=settings, stop=stop)

    numbers = [one for one in chosen.hypothesis if takeover(one, chosen) and one.name not in search.base.names]
    if not numbers:
        return chosen
    full = fitted(chosen.predictor, chosen.theta)
    for one in numbers:
        if len(chosen.hypothesis) == 1 or search.deadline.stops_finishing():
            break
        rest = tuple(other for other in full.hypothesis if other is not one)
        start = full.theta[~full.columns([one.name])]
        without = fitted(search.null.predictor(rest), start)
        if not worth(search, compare(data, search.null.fit, [without, full]), without, full, removed):
            full, chosen = without, search.completed(search.without(chosen, one.name))
            fits.append(chosen)
    return chosen
