"""A search that goes on where numbers of the model ended at the limit of theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.candidates.tolerance import FARTHER
from flexros.gap.fit.limits import numbers_at_limits
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.search.forward_selection import explain
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.torque_start import on_null
from flexros.robot.parameters import DAMPER

if TYPE_CHECKING:
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations


def found_wider(search: Search, explanations: Explanations, held: FitData) -> tuple[Search, Explanations]:
    """Go on from an explanation of a measured log that moved tolerated numbers to the limit of their search.

    Such a number has the value of none, and bends all others. Where torques show what to begin with, the search begins
    there once more. Without torques numbers that may go anywhere take the place of effects at first; beside effects
    that are found they tell what they are. Both logs must be for it. The damping of a spring hardly shows beside the
    tolerance of torques, which it takes up at any size: it alone is no reason.

    Args:
        search: The search that found it.
        explanations: The explanation, with all fits.
        held: The held-out log.

    Returns:
        A search in which these numbers go farther and what it found, or the given ones.
    """
    chosen, deadline = explanations.chosen, search.deadline
    found_any = explanations.detected and explanations.beside is None
    ended = found_any and any(not name.endswith(DAMPER) for name in numbers_at_limits(chosen))
    widest = search.null.fit.predictor.tolerance.farthest >= FARTHER
    if search.premises.library_is_complete or not ended or widest or deadline.stops():
        return search, explanations
    null = search.null.farther()
    of_torques = search.from_torques and search.data.record.command is None
    first = on_null(null, search.base if of_torques else chosen)
    begun = prepare_search(null, search.settings, search.progress, deadline, first)
    further = prepare_search(null, search.settings, search.progress, deadline, begun.completed(first))
    found = explain(further)
    better = found.chosen.chi2 < chosen.chi2 and not deadline.over  # what was cut short compares with less
    if not better or errors_ahead(found.chosen, held).mean >= errors_ahead(chosen, held).mean:
        return search, explanations
    return further, found
