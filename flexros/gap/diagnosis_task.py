"""The search of a log for causes, and its answer: what is done once for each way in which a log is weighed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.gap.answer.assemble import result_of
from flexros.gap.answer.decision import findings_of, on_held_out
from flexros.gap.answer.rest_of_log import changes_over_log
from flexros.gap.answer.rivals.most_probable import most_probable
from flexros.gap.answer.sensitivity import sensitivity_of
from flexros.gap.answer.withdrawal import confirmed
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.torques.noted_timing import shift_of_noted
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor
from flexros.gap.held_out.predictions import prediction_of, sensor_errors, tool_errors
from flexros.gap.noise.autoregression import autoregressive_spectrum
from flexros.gap.residuals.prepare_fit_data import with_tool_frame_of
from flexros.gap.schema import ANSWERED, GAP_ALONE, REST
from flexros.gap.search.forward_selection import explain, explanations_of
from flexros.gap.search.looser import found_looser, looser_null
from flexros.gap.search.model_probability import compare
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.servos.start import fit_of_servos
from flexros.gap.search.torque_start import base_fit, first_values, on_null, with_load
from flexros.gap.search.worth import beyond_noise, compared
from flexros.gap.weighed_logs import used_logs, weighed_logs
from flexros.gap.where.find import where
from flexros.gap.wider_numbers import found_wider
from flexros.identify.rigid.torque_timing import in_time
from flexros.logs.reader import give_memory_back

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.deadline import Deadline
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.progress import Stages
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.search.fits.candidate_fits import Search
    from flexros.gap.search.forward_selection import Explanations
    from flexros.gap.settings import DiagnosisSettings
    from flexros.gap.weighed_logs import WeighedLogs
    from flexros.gap.where.find import Where
    from flexros.record.record import Record

NOMINAL_MODEL = "nominal model"
"""Name of the stage and step in which the nominal model is fitted."""
NOMINAL, SERVOS, WHERE, CAUSES, ANSWER = 0.06, 0.25, 0.11, 0.97, 0.99
"""Shares of a diagnosis that are done at the ends of its stages [1]: about the medians of their times in diagnoses of
measured robots, see `BEGINS`; logs of servos have that stage in place of `WHERE`."""


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
        closely_tied: The nominal model and the held-out log as both were before the search tied the logs more loosely;
            None where it did not.
        rest: Pieces of what is not used of long logs.
    """

    record: Record
    null: NullFit
    held_data: FitData
    unknown: UnknownNumbers
    prediction: PredictedLog
    excess: Where | None
    search: Search
    explanations: Explanations
    closely_tied: tuple[CandidateFit, FitData] | None = None
    rest: tuple[Record, ...] = ()

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
        stages: Progress of the diagnosis; each search goes through them once more.
        rough_gains: Whether the servos have gains by the log, whose scale gravity alone fixes.
        torques_better: Whether the torques turned out better than was assumed.
    """

    given: RobotWithEffects
    holdout: Record | None
    tolerance: Mapping[str, float]
    notes: tuple[str, ...]
    settings: DiagnosisSettings
    deadline: Deadline
    stages: Stages
    rough_gains: bool = False
    torques_better: bool = False

    def searched(self, record: Record, begun: CandidateFit | None = None, most: float = math.inf) -> SearchedLog:
        """Weigh a log, and search for what explains it.

        Args:
            record: The log.
            begun: An explanation that the search begins with; default: what the torques show.
            most: What that may leave beyond noise in this log, over the tolerance of torques; with more, or where no
                candidates promise to explain most of it, it is the answer [1]. Default: it is searched on in any case.
        """
        settings, deadline, stages = self.settings, self.deadline, self.stages
        stages.again()
        stages.begin(NOMINAL_MODEL, NOMINAL)
        deadline.begin(NOMINAL_MODEL)
        logs = self._weighed(record)
        null, base = _first_fits(logs, begun, settings, deadline, stages)
        shift = None if deadline.over else shift_of_noted(base or null.fit, null, settings)
        if shift is not None:
            return self.searched(in_time(record, shift), begun, most)
        first = null
        null = null if logs.start is not None else self._looser(null, logs)
        prediction = prediction_of(null.fit, null.data)

        stages.begin("where", WHERE if null.data.record.command is None else SERVOS)
        deadline.begin("where")
        left_out = settings.where is None or deadline.stops()
        excess = None if left_out else _where(null, prediction, settings, deadline.stops)

        stages.begin("causes", CAUSES)
        search = prepare_search(null, settings, stages.inner, deadline, base)
        if base is not None and beyond_noise(search, base) > most:
            explanations = explanations_of(search, compared(search, [base]), base, detected=True)
        else:
            promised = 1 - settings.search.within_floor if most < math.inf else 0.0
            search, explanations = found_looser(search, explain(search, promised), logs.used.fitted, logs.tolerance)
        resumed = explanations.chosen if search.resumed else None
        search, explanations = found_wider(search, explanations, _held_alike(logs, search.null, resumed))
        if search.null is not null:
            null, prediction = search.null, prediction_of(search.null.fit, search.null.data)
        held_data = _held_alike(logs, null, explanations.chosen if search.resumed else None)
        looser = held_data.torque_noise < logs.held_data.torque_noise
        tied = (first.fit, logs.held_data) if looser else None
        rest = logs.used.rest
        return SearchedLog(record, null, held_data, logs.unknown, prediction, excess, search, explanations, tied, rest)

    def _weighed(self, record: Record) -> WeighedLogs:
        """Prepare and weigh a log and the held-out one."""
        used = used_logs(record, self.holdout, self.given, self.settings)
        return weighed_logs(used, self.given, self.tolerance, self.notes, self.settings, rough_gains=self.rough_gains)

    def _looser(self, null: NullFit, logs: WeighedLogs) -> NullFit:
        """Tie the log as loosely as the nominal model with its tolerated numbers allows."""
        fitted, stop = logs.used.fitted, self.deadline.of_fit
        while not self.deadline.stops():
            looser = looser_null(null, fitted, logs.tolerance, self.settings, stop=stop())
            if looser is None:
                break
            null = looser
        return null

    def answered(self, found: SearchedLog) -> DiagnosisResult:
        """Decide what the explanations say, and check them on the held-out log.

        Args:
            found: The explanations.
        """
        settings, deadline, stages = self.settings, self.deadline, self.stages
        deadline.release()
        kept = confirmed(found.search, found.explanations, found.held_data)
        stages.begin(ANSWERED, ANSWER)
        deadline.begin(ANSWERED)
        give_memory_back()  # what many fits left behind; predictions with their states need most
        model, searched = found.null.model, kept.explanations.beside or found.null.data
        sensitivity = sensitivity_of(
            kept.explanations, searched, model, found.unknown, settings.sensitivity, deadline.stops
        )
        findings = findings_of(
            model,
            searched,
            found.held_data,
            most_probable(found.search, sensitivity.explanations, found.held_data, sensitivity.elsewhere),
            names_by_tolerance=sensitivity.rows,
            elsewhere=sensitivity.elsewhere,
            given=self.given,
            unknown=found.unknown,
            tolerance=self.tolerance,
            settings=settings.ranking,
            complete=deadline.partial is None,
            withdrawn=kept.withdrawn,
            fitted_around=kept.fitted_around,
            torques_better=self.torques_better,
            stop=deadline.of_fit(finishing=True),
        )
        result = result_of(findings, found.prediction, found.excess, settings, stages, deadline)
        return _with_rest(result, found, findings.repaired, deadline) if found.rest or found.closely_tied else result


def _with_rest(
    result: DiagnosisResult, found: SearchedLog, repaired: CandidateFit, deadline: Deadline
) -> DiagnosisResult:
    """Add to an answer the gap as it was before the search tied the logs more loosely, and what their rest shows.

    Args:
        result: The answer.
        found: The explanations.
        repaired: What the patch holds.
        deadline: Leaves out what there is no time for.
    """
    diagnosis, tied = result.diagnosis, found.closely_tied
    if tied is not None and not deadline.leaves_out(GAP_ALONE):
        before = over_expected_floor(errors_ahead(*tied), found.null.model, tied[1]).mean
        diagnosis = diagnosis.model_copy(update={"gap": diagnosis.gap.model_copy(update={"before_alone": before})})
    if found.rest and not deadline.leaves_out(REST):
        changes = changes_over_log(found.rest, repaired, found.null)
        diagnosis = diagnosis.model_copy(update={"warnings": (*changes, *diagnosis.warnings)})
    return replace(result, diagnosis=diagnosis)


def _beyond_noise(search: Search, fit: CandidateFit, held: FitData) -> float:
    """Return what a fit leaves beyond noise in the log where it leaves more, over the tolerance of torques [1].

    Args:
        search: The search in the fitted log.
        fit: The fit.
        held: The held-out log.
    """
    elsewhere = compare(held, on_held_out(search.null.fit, held), settings=search.settings.ranking)
    return max(beyond_noise(search, fit), elsewhere.beyond_noise(elsewhere.level(on_held_out(fit, held))))


def _held_alike(logs: WeighedLogs, null: NullFit, explanation: CandidateFit | None) -> FitData:
    """Weigh the held-out log as the fitted one of a search, with its tool where a model predicts it.

    Args:
        logs: Both logs.
        null: The nominal model of the search.
        explanation: What an earlier search of the same log ended with; None for the nominal model.
    """
    best, held = explanation or null.fit, logs.held_data
    if null.data.torque_noise < logs.data.torque_noise:
        held = logs.held_looser(null.data.torque_noise, None if explanation is None else (best.predictor, best.theta))
    return with_tool_frame_of(held, best.predictor, best.theta)


def _first_fits(
    logs: WeighedLogs,
    begun: CandidateFit | None,
    settings: DiagnosisSettings,
    deadline: Deadline,
    stages: Stages,
) -> tuple[NullFit, CandidateFit | None]:
    """Fit the nominal model, and the effects that torques show, or those of an explanation to begin with.

    On a real machine the prior of tolerances is weighed by what these effects leave, or what no candidate removes.
    """
    data, model, tolerance, start = logs.data, logs.model, logs.tolerance, logs.start
    few = settings.fit.model_copy(update={"null_iterations": 1})  # what the torques show is fitted from the torques
    first_settings = settings.fit if start is None else few
    stop = stages.of_fit(first_settings.null_iterations, deadline.of_fit())
    null = fit_null(data, model, tolerance, first_settings, stop=stop)
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
    if data.record.premises.floor_is_noise or not tolerance.names or deadline.stops():
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


def _where(null: NullFit, prediction: PredictedLog, settings: DiagnosisSettings, stop: Callable[[], bool]) -> Where:
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
        stop=stop,
    )
