"""The search of a log for causes, and its answer: what is done once for each way in which a log is weighed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.gap.answer.assemble import result_of
from flexros.gap.answer.decision import findings_of, on_held_out
from flexros.gap.answer.sensitivity import sensitivity_of
from flexros.gap.answer.withdrawal import confirmed
from flexros.gap.candidates.tolerance import scaled_by_gravity, tolerance_of
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.torques.noted_timing import shift_of_noted, with_torque_in_time_behind_springs
from flexros.gap.fit.torques.unknown_numbers import unknown_numbers
from flexros.gap.held_out.predictions import prediction_of, sensor_errors, tool_errors
from flexros.gap.held_out.split import split
from flexros.gap.noise.autoregression import autoregressive_spectrum
from flexros.gap.noise.weights import measurement_in
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_samples import part_of_fits
from flexros.gap.residuals.prepare_fit_data import fit_data, with_tool_frame_of
from flexros.gap.search.forward_selection import explain, explanations_of
from flexros.gap.search.looser import found_looser, looser_null
from flexros.gap.search.model_probability import compare
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.servo_start import fit_of_servos
from flexros.gap.search.torque_start import base_fit, first_values, on_null, torque_start, with_load, with_torques
from flexros.gap.search.worth import beyond_noise, compared
from flexros.gap.where.find import where
from flexros.identify.rigid.torque_timing import in_time
from flexros.logs.reader import give_memory_back
from flexros.record.prescribed_motion import with_prescribed_motion
from flexros.record.resampled import may_be_resampled, resampled
from flexros.record.torques.shifted_torque import shifted

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.deadline import Deadline
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.search.torque_start import TorqueStart
    from flexros.gap.settings import DiagnosisSettings
    from flexros.gap.where.find import Where
    from flexros.record.record import Record
    from flexros.robot import Robot

NOMINAL, SERVOS, WHERE, CAUSES, ANSWER = 0.15, 0.25, 0.16, 0.94, 0.99
"""Shares of a diagnosis that are done at the ends of its stages [1] (chosen): about the medians of their times on the
measured robots; logs of servos have that stage in place of `WHERE`."""


@dataclass(frozen=True, eq=False)
class SearchedLog:
    """The explanations of a log, and what they were found with.

    Attributes:
        record: The log.
        null: The nominal model, fitted to the part of it that is used.
        held_data: The held-out log.
        unknown: Numbers that the model lacks, with their values by the log.
        prediction: What the nominal model predicts.
        excess: Where the gap shows; None where that was not computed.
        search: The search.
        explanations: What it found.
        stages: Progress of the diagnosis.
    """

    record: Record
    null: NullFit
    held_data: FitData
    unknown: UnknownNumbers
    prediction: PredictedLog
    excess: Where | None
    search: Search
    explanations: Explanations
    stages: Stages

    def beyond_noise(self, fit: CandidateFit) -> float:
        """Return what a fit leaves beyond noise in the log where it leaves more, over the tolerance of torques [1]."""
        return _beyond_noise(self.search, fit, self.held_data)


@dataclass(frozen=True, eq=False)
class DiagnosisTask:
    """What is diagnosed against, and how: it stays the same where a log is searched again.

    Attributes:
        given: The model as it was given.
        holdout: Second log; None: the last part of the first.
        tolerance: Relative tolerances other than those of the robot file [1].
        notes: Sentences for the warnings.
        settings: Settings of the diagnosis.
        deadline: When the search ends.
        progress: Called with the name of the stage and the share of all that is done.
        rough_gains: Whether the servos have gains by the log, whose scale gravity alone fixes.
    """

    given: RobotWithEffects
    holdout: Record | None
    tolerance: Mapping[str, float]
    notes: tuple[str, ...]
    settings: DiagnosisSettings
    deadline: Deadline
    progress: Callable[[str, float], None] | None
    rough_gains: bool = False

    def searched(self, record: Record, begun: CandidateFit | None = None, most: float = math.inf) -> SearchedLog:
        """Weigh a log, and search for what explains it.

        Args:
            record: The log.
            begun: An explanation that the search begins with; default: what the torques show.
            most: What that may leave beyond noise, over the tolerance of torques; with more, or where no candidates
                promise to explain most of it, it is the answer [1].
        """
        settings, deadline, stages = self.settings, self.deadline, Stages(self.progress)
        stages.begin("nominal model", NOMINAL)
        fitted, held = (record, self.holdout) if self.holdout is not None else split(record, settings.fitted_share)
        fitted, held = _prescribed_alike(fitted, held, self.given.robot)
        model = driven_model(self.given, fitted)
        _check_alike(fitted, held)
        fitted = with_torque_in_time_behind_springs(fitted, model.robot, settings)
        held = resampled(shifted(held, fitted.torque_shift), fitted.sample_time)
        fitted, held = (part_of_fits(one, model.robot, settings) for one in (fitted, held))
        stated = tolerance_of(model.robot, self.tolerance, fitted.prescribed)
        unknown = unknown_numbers(fitted, model, stated, settings.torque_start)
        fitted = replace(fitted, warnings=(*fitted.warnings, *unknown.warnings, *self.notes))
        model = unknown.given_to(model)
        tolerated = unknown.tolerated(tolerance_of(model.robot, self.tolerance, fitted.prescribed), model.robot)
        tolerated = scaled_by_gravity(tolerated) if self.rough_gains else tolerated
        give_memory_back()  # what was needed of a long log beside the part that is used
        data = fit_data(fitted, model, settings)
        measurement = measurement_in(held, model.robot, data.measurement, settings)
        held_data = fit_data(held, model, settings, measurement, data.level)
        start = torque_start(data, model, tolerated, settings)
        data = with_torques(data, start)
        null, base = _first_fits(data, model, tolerated, start, begun, settings, deadline, stages)
        shift = shift_of_noted(base or null.fit, null, settings)
        if shift is not None:
            return self.searched(in_time(record, shift), begun, most)
        if start is None:
            while (looser := looser_null(null, fitted, tolerated, settings, stop=deadline.of_fit())) is not None:
                null = looser
        prediction = prediction_of(null.fit, null.data)

        stages.begin("where", WHERE if fitted.command is None else SERVOS)
        deadline.begin("where")
        excess = None if settings.where is None or deadline.stops() else _where(null, prediction, settings)

        stages.begin("causes", CAUSES)
        search = prepare_search(null, settings, stages.inner, deadline, base)
        if base is not None and most < math.inf and _beyond_noise(search, base, held_data) > most:
            explanations = explanations_of(search, compared(search, [base]), base, detected=True)
        else:
            promised = 0.0 if begun is None else 1 - settings.search.within_floor
            search, explanations = found_looser(search, explain(search, promised), fitted, tolerated)
        if search.null is not null:
            null, prediction = search.null, prediction_of(search.null.fit, search.null.data)
        best = explanations.chosen if search.resumed else null.fit
        if null.data.level < data.level:
            around = (best.predictor, best.theta) if search.resumed else None
            held_data = fit_data(held, model, settings, measurement, null.data.level, around)
        held_data = with_tool_frame_of(held_data, best.predictor, best.theta)
        return SearchedLog(record, null, held_data, unknown, prediction, excess, search, explanations, stages)

    def answered(self, found: SearchedLog) -> DiagnosisResult:
        """Decide what the explanations say, and check them on the held-out log.

        Args:
            found: The explanations.
        """
        settings, deadline, stages = self.settings, self.deadline, found.stages
        explanations, withdrawn = confirmed(found.search, found.explanations, found.held_data)
        stages.begin("answer", ANSWER)
        model, searched = found.null.model, explanations.beside or found.null.data
        sensitivity = sensitivity_of(explanations, searched, model, found.unknown, settings.sensitivity, deadline.stops)
        findings = findings_of(
            model,
            searched,
            found.held_data,
            sensitivity.explanations,
            names_by_tolerance=sensitivity.rows,
            elsewhere=sensitivity.elsewhere,
            given=self.given,
            unknown=found.unknown,
            tolerance=self.tolerance,
            settings=settings.ranking,
            complete=deadline.partial is None,
            withdrawn=withdrawn,
            stop=deadline.of_fit(finishing=True),
        )
        return result_of(findings, found.prediction, found.excess, settings, stages, deadline)


def _beyond_noise(search: Search, fit: CandidateFit, held: FitData) -> float:
    """Return what a fit leaves beyond noise in the log where it leaves more, over the tolerance of torques [1].

    Args:
        search: The search in the fitted log.
        fit: The fit.
        held: The held-out log.
    """
    elsewhere = compare(held, on_held_out(search.null.fit, held), settings=search.settings.ranking)
    return max(beyond_noise(search, fit), elsewhere.beyond_noise(elsewhere.level(on_held_out(fit, held))))


def _first_fits(
    data: FitData,
    model: RobotWithEffects,
    tolerance: Tolerance,
    start: TorqueStart | None,
    begun: CandidateFit | None,
    settings: DiagnosisSettings,
    deadline: Deadline,
    stages: Stages,
) -> tuple[NullFit, CandidateFit | None]:
    """Fit the nominal model, and the effects that torques show, or those of an explanation to begin with.

    On a real machine the prior of tolerances is weighed by what these effects leave, or what no candidate removes.
    """
    few = settings.fit.model_copy(update={"null_iterations": 1})  # what the torques show is fitted from the torques
    first_settings = settings.fit if start is None else few
    null = fit_null(data, model, tolerance, first_settings, stop=deadline.of_fit())
    first = None if start is None else first_values(start, null, settings)
    if begun is not None:
        first, start = on_null(null, begun), None
    if data.record.command is not None:
        stages.begin("servos", SERVOS)
    of_servos = fit_of_servos(null, first, settings, deadline.of_fit(), stages.inner)
    if of_servos is not None and (first is None or of_servos.chi2 < first.chi2):
        first = of_servos
    base = None if first is None else base_fit(null, first, settings, deadline.of_fit())
    if base is not None and start is not None and start.loaded is not None:
        base = with_load(null, base, start.loaded, settings, deadline.of_fit())
    if data.record.premises.floor_is_noise or not tolerance.names:
        return null, base
    if base is not None:
        misfit = max(base.chi2 / data.n_values, 1.0)
    else:
        search = prepare_search(null, settings, deadline=deadline)
        misfit = search.misfit(search.directions(search.candidates()))
    found = null.fit if base is None else base
    start_at = found.predictor.tolerance.by_name(found.deviations)
    null = fit_null(replace(data, misfit=misfit), model, tolerance, settings.fit, start_at, stop=deadline.of_fit())
    return null, None if base is None else base_fit(null, on_null(null, base), settings, deadline.of_fit())


def _where(null: NullFit, prediction: PredictedLog, settings: DiagnosisSettings) -> Where:
    """Compute where the gap shows: in the motors, in the tool where that was tracked, in further sensors."""
    data, whitening = null.data, null.data.measurement.whitening
    tool, error = tool_errors(null.fit, data) or (None, None)
    return where(
        prediction,
        replace(data.record, valid=data.settled, tool=tool),
        null.model.robot,
        settings.seed,
        settings=settings.where,
        tool_error=error,
        sensors=sensor_errors(null.fit, data),
        spectrum=autoregressive_spectrum(-whitening[:, 1:].T) if whitening.shape[1] > 1 else None,
    )


def _prescribed_alike(fitted: Record, held: Record, robot: Robot) -> tuple[Record, Record]:
    """Let the motion of the same motors drive the model in both logs."""
    return (
        with_prescribed_motion(fitted, robot, held.prescribed, f"it does so in {held.name}"),
        with_prescribed_motion(held, robot, fitted.prescribed, f"it does so in {fitted.name}"),
    )


def _check_alike(fitted: Record, held: Record) -> None:
    """Refuse a holdout that was recorded in another way, for which the fitted predictors do not hold."""
    ways = [
        f"{record.name} has {1 / record.sample_time:.6g} samples per second and {record.driven_by}"
        for record in (held, fitted)
    ]
    if not may_be_resampled(held, fitted.sample_time):
        raise InputError(
            f"{ways[0]}, but {ways[1]}; exchange the two, so that the one with more samples is held out, or give none"
        )
    if held.driven_by != fitted.driven_by:
        raise InputError(f"{ways[0]}, but {ways[1]}; give a holdout that was recorded like the log, or none")
