"""The diagnosis of a log, from beginning to end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.blas_threads import one_blas_thread
from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.answer.assemble import result_of
from flexros.gap.answer.decision import Findings
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.held_out.closed_loop_gap import closed_loop_gap
from flexros.gap.held_out.predictions import tool_errors
from flexros.gap.noise.autoregression import autoregressive_spectrum
from flexros.gap.noise.weights import measurement_in
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_data import fit_data
from flexros.gap.search.candidate_fits import Search
from flexros.gap.search.forward_selection import explain
from flexros.gap.settings import DiagnosisSettings
from flexros.gap.where.find import where

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.gap.result import DiagnosisResult, Explanation
    from flexros.gap.where.find import Where
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.robot import Robot


SAME_RATE = 1e-3
"""Relative difference of sample times up to which two logs have the same rate [1] (chosen)."""


@one_blas_thread()
def diagnose(
    record: Record,
    robot: Robot | RobotWithEffects,
    *,
    holdout: Record | None = None,
    log: Log | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> DiagnosisResult:
    """Diagnose the gap between a recorded robot and its model.

    Args:
        record: The log that effects are fitted to.
        robot: The nominal model: a robot, or one with effects that are known already.
        holdout: Second log, read once at the end; default: the last third of the first.
        log: The log that `holdout` was read from, or `record` where there is no second one. Where its provenance names
            reference and controller, the gap in closed loop is computed as well; default: it is not.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file.
        settings: Numbers of the diagnosis.
        progress: Called with the name of the stage and the share of all that is done.

    Returns:
        What was found, with the evidence.

    Raises:
        InputError: A log that nothing can be told from, or a holdout that was recorded in another way.
    """
    numbers = settings or DiagnosisSettings()
    model = robot if isinstance(robot, RobotWithEffects) else RobotWithEffects(robot, ())
    stages = Stages(progress)
    fitted, held = (record, holdout) if holdout is not None else split(record, numbers.fitted_share)
    _check_alike(fitted, held)
    data = fit_data(fitted, model, numbers)
    held_data = fit_data(held, model, numbers, measurement_in(held, model.robot, data.measurement))
    search = Search(model, data, tolerance_of(model.robot, tolerance or {}), stages.inner)
    search.threads = numbers.threads or search.threads
    stages.begin("causes", 0.8)
    explanations = explain(search)
    stages.begin("held-out data", 0.85)
    nothing = explanations.evidence.nothing
    held_data = held_data.tool_seen_by(nothing.predictor, nothing.theta)
    found = Findings(model, search.data, held_data, explanations, dict(tolerance or {}))
    stages.begin("places", 0.9)
    before = found.explanation(explanations.evidence.nothing)
    places = _places(found, before, numbers.seed) if numbers.where else None
    stages.begin("answer", 0.95)
    result = result_of(found, before, places, {**numbers.model_dump(), **found.tolerance}, stages)
    if log is not None:
        stages.begin("closed loop", 1.0)
        repaired = model.with_effects(result.patch) if result.patch else None
        signals = closed_loop_gap(log, model, repaired, begin=held_data.record.begin)
        result = replace(result, signals=(*result.signals, *signals))
    stages.end()
    return result


def _places(found: Findings, before: Explanation, seed: int) -> Where:
    """Look where the gap shows, with what the tool tracker adds."""
    data, whitening = found.data, found.data.measurement.whitening
    tool, error = tool_errors(found.explanations.evidence.nothing, data) or (None, None)
    return where(
        before.fit,
        replace(data.record, valid=data.settled, tool=tool),
        found.model.robot,
        seed,
        tool_error=error,
        spectrum=autoregressive_spectrum(-whitening[:, 1:].T) if whitening.shape[1] > 1 else None,
    )


def split(record: Record, share: float) -> tuple[Record, Record]:
    """Set the last part of a log aside.

    Args:
        record: The log.
        share: Share of it that is fitted to [1].
    """
    border = int(share * record.n_samples)
    return record.part(0, border), record.part(border, record.n_samples)


def _check_alike(fitted: Record, held: Record) -> None:
    """Refuse a holdout that was recorded in another way, which the predictors of the fit do not fit."""
    ways = [
        f"{one.name} has {1 / one.sample_time:.6g} samples per second and "
        f"{'measured' if one.measured_torque else 'commanded'} torques"
        for one in (held, fitted)
    ]
    if abs(held.sample_time / fitted.sample_time - 1) > SAME_RATE or held.measured_torque != fitted.measured_torque:
        raise InputError(f"{ways[0]}, but {ways[1]}; give a holdout that was recorded like the log, or none")
