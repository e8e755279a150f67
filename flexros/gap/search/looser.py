"""A log tied more loosely to its encoders, once tolerated numbers or an explanation predict it well.

While the nominal model is far off, the observer follows the encoders closely, see `fit_data`. What it follows it does
not predict: with ten times the torque noise, slow effects show about a hundredth of what they do in squares. How far
off the nominal model was is no reason to go on so once its tolerated numbers are fitted, or effects are found.

The torque noise is to be no less than what the form of the effects makes. That shows: an explanation that leaves noise
at one torque noise and more at a smaller one has met its errors of form there, unless further effects take up the rest.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from flexros.gap.fit.null_fit import NullFit, fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.residuals.prepare_fit_data import fit_data, with_tool_frame_of
from flexros.gap.search.forward_selection import explain
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.torque_start import on_null
from flexros.gap.search.worth import in_vain

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record

STEP = 10.0
"""Factor by which the torque noise falls from one search to the next [1] (chosen), as it rises in `fit_data`."""


def looser_null(
    null: NullFit,
    record: Record,
    tolerance: Tolerance,
    settings: DiagnosisSettings,
    around: CandidateFit | None = None,
    least: float = 0.0,
    stop: Callable[[], bool] | None = None,
) -> NullFit | None:
    """Fit the nominal model to a simulated log that is tied as loosely as an explanation allows.

    Args:
        null: The nominal model, fitted.
        record: The log, as it was before it was weighed.
        tolerance: Parameters of the robot that may deviate.
        settings: Settings of the diagnosis.
        around: The explanation; default: the nominal model with its fitted numbers.
        least: Least torque noise [1].
        stop: Asked after each iteration; True ends the fit where it is.

    Returns:
        The fit; None where the log is tied as loosely already, and for one of a real machine, which is tied as the
        tolerance of its torques says.
    """
    data, fit = null.data, null.fit if around is None else around
    if not data.least_torque_noise < data.torque_noise:
        return None
    weigh = partial(fit_data, record, null.model, settings, data.measurement, around=(fit.predictor, fit.theta))
    again = weigh()
    if not again.torque_noise < data.torque_noise:
        return None
    if again.torque_noise < least:
        again = replace(weigh(torque_noise=least), least_torque_noise=again.least_torque_noise)
    start = fit.predictor.tolerance.by_name(fit.deviations)
    return fit_null(again, null.model, tolerance, settings.fit, start, stop)


def found_looser(
    search: Search, explanations: Explanations, record: Record, tolerance: Tolerance
) -> tuple[Search, Explanations]:
    """Go on from an explanation that leaves noise, in the same log tied more loosely, for as long as it leaves noise.

    Each step allows for a tenth of the torque noise. Where the search cannot explain all that shows then, the errors of
    form of its effects are part of that, and candidates imitate them: the explanation of the step before is the answer.
    Noise whose size is not known exactly was what that explanation left: the same noise leaves no more now.

    Args:
        search: The search that found it.
        explanations: The explanation, with all fits.
        record: The log, as it was before it was weighed.
        tolerance: Parameters of the robot that may deviate.

    Returns:
        The last search whose explanation leaves noise, or the given one, and what it found.
    """
    while explanations.beside is None and not explanations.comparison.significant(explanations.chosen):
        further = _looser_search(search, explanations.chosen, record, tolerance)
        if further is None:
            break
        found = explain(further)
        if search.deadline.over or found.comparison.significant(found.chosen) or in_vain(further, found.chosen):
            break
        search, explanations = further, found
    return search, explanations


def _looser_search(search: Search, chosen: CandidateFit, record: Record, tolerance: Tolerance) -> Search | None:
    """Prepare a search that goes on from an explanation in the log tied more loosely; None where it is tied so already.

    Args:
        search: The search that found it.
        chosen: The explanation; the nominal model where no effect was detected.
        record: The log, as it was before it was weighed.
        tolerance: Parameters of the robot that may deviate.
    """
    settings, deadline = search.settings, search.deadline
    if deadline.stops():
        return None
    least = search.data.torque_noise / STEP
    null = looser_null(search.null, record, tolerance, settings, chosen, least, deadline.of_fit())
    if null is None:
        return None
    if not chosen.hypothesis:
        return prepare_search(null, settings, search.progress, deadline)
    first = on_null(null, chosen)
    if null.data.tool is not None:  # the frame of the tracker by what predicts the log best
        data = with_tool_frame_of(null.data, first.predictor, first.theta)
        theta = null.fit.theta
        null = NullFit(
            null.model, data, replace(null.fit, chi2=float(chi2_of(null.fit.predictor, data, theta[:, None])[0]))
        )
        first = on_null(null, first)
    left = chosen.chi2 / search.data.n_values
    begun = prepare_search(null, settings, search.progress, deadline, first, left_before=left)
    return prepare_search(null, settings, search.progress, deadline, begun.completed(first), left_before=left)
