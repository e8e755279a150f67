"""The best result that a diagnosis could reach: the true structure fitted to the same log."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects import RobotWithEffects
from flexros.validation.blind.diagnose_case import case_settings, read_logs
from flexros.validation.blind.score.answer import VISIBLE
from flexros.validation.blind.score.nested import same_place

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.gap.candidates.candidate import Candidate
    from flexros.validation.blind.seal import OpenCase, Truth


def oracle_fraction(folder: Path, case: OpenCase, truth: Truth) -> float | None:
    """Fit the true effect at its true location and compute the closed fraction on the second log.

    Args:
        folder: Folder of the case, with its logs.
        case: What is open of it.
        truth: What is hidden in it.

    Returns:
        Closed fraction [1]; None where nothing, or more than one effect, or one that is no matter of fitting is hidden,
        or where the gap does not show on the second log.
    """
    from flexros.gap.candidates.tolerance import tolerance_of
    from flexros.gap.fit.null_fit import fit_null
    from flexros.gap.held_out.closed_share import closed_fraction
    from flexros.gap.held_out.errors_ahead import errors_ahead
    from flexros.gap.held_out.gap_floor import over_expected_floor
    from flexros.gap.noise.weights import measurement_in
    from flexros.gap.residuals.prepare_fit_data import fit_data, with_tool_frame_of
    from flexros.gap.search.prepare import prepare_search

    if truth.kind != "single" or truth.gain < VISIBLE:
        return None
    robot, record, holdout = read_logs(folder, case)
    model = RobotWithEffects(robot, ())
    settings = case_settings()
    data = fit_data(record, model, settings)
    measurement = measurement_in(holdout, robot, data.measurement, settings)
    held = fit_data(holdout, model, settings, measurement, data.torque_noise)
    null = fit_null(data, model, tolerance_of(robot, {}), settings.fit)
    held = with_tool_frame_of(held, null.fit.predictor, null.fit.theta)
    search = prepare_search(null, settings)
    true = _true((*search.candidates(), *search.harmonics(null.fit)), robot.name, truth)
    if not true:
        return None
    hidden = truth.deviations[0].effect
    fits = [fit for fit in search.singles(search.directions(true)) if fit.hypothesis[0].effect.name == hidden]
    if not fits:
        return None
    before = over_expected_floor(errors_ahead(null.fit, held), model, held)
    share = closed_fraction(before, errors_ahead(fits[0], held), held.record.sample_time)
    return None if share is None else share.value


def _true(candidates: Sequence[Candidate], robot: str, truth: Truth) -> list[Candidate]:
    """List the true effect at its location, and the simpler ones that give its initial values."""
    hidden = truth.deviations[0]
    here = [one for one in candidates if same_place(robot, hidden.location, one.location)]
    simpler = {part for one in here if one.effect.name == hidden.effect for part in one.effect.extends}
    chosen = [one for one in here if one.effect.name == hidden.effect or one.effect.name in simpler]
    return chosen if any(one.effect.name == hidden.effect for one in chosen) else []
