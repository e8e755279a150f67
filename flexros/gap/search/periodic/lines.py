"""A search beside a line: what acts at a frequency of its own hides all effects that are smaller."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.line import line_in
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.worth import compared

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.line import Line
    from flexros.gap.search.fits.candidate_fits import Search


def beside_line(search: Search, chosen: CandidateFit, *others: CandidateFit) -> Search | None:
    """Prepare a search beside what acts at one frequency all the time, where that is most of what is left in a log.

    No effect of the library does so: friction, springs and rotors follow the motion. Left in, it decides what seems to
    gain in the rest, and each true effect removes a small part of it. Beside it, the others show as before.

    Args:
        search: The search.
        chosen: The best explanation so far.
        others: Other fits that must leave the same line, such as that of the nominal model.

    Returns:
        The new search, which begins with the nominal model; None where no line is left, where the explanation
        suffices, and on real machines, whose motion may repeat.
    """
    data, settings = search.data, search.settings
    if (
        not search.premises.library_is_complete
        or search.from_torques
        or search.resumed
        or data.line is not None
        or search.deadline.stops()
    ):
        return None
    if compared(search, [chosen]).adequate(chosen):
        return None
    line, *further = (_line_left_by(search, fit) for fit in (chosen, *others))
    reach = settings.search.line_itself * settings.search.line_width
    if line is None or any(one is None or abs(one.frequency - line.frequency) > reach for one in further):
        return None
    null, tolerance = search.null, search.null.fit.predictor.tolerance
    start, every = tolerance.by_name(null.fit.deviations), replace(tolerance, directions=None)
    told = f"something acts at {line.frequency:.4g} Hz all the time, which no effect does; causes were sought beside it"
    record = replace(data.record, warnings=(*data.record.warnings, told))
    beside, stop = replace(data, record=record, line=line), search.deadline.of_fit()
    again = fit_null(beside, null.model, every, settings.fit, start, stop)
    return prepare_search(again, settings, search.progress, search.deadline)


def _line_left_by(search: Search, fit: CandidateFit) -> Line | None:
    n, M = search.data.record.position.shape
    motors, numbers = fit.residual(search.data)[: M * n].reshape(M, n), search.settings.search
    sample_time = search.data.record.sample_time
    return line_in(motors, sample_time, numbers.line_width, numbers.line_share, numbers.line_itself)
