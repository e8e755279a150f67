"""The answer of a diagnosis, put together: causes, ranking, gap numbers, warnings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.budget import Budget, budget_of, without_gap
from flexros.gap.answer.decision import (
    best_rival,
    effect_location,
    groups_of,
    held_out_gain,
    probability_of,
    rank_key,
    repair_of,
    rivals_of,
    verdict_of,
)
from flexros.gap.answer.limits import identifiability_limits
from flexros.gap.answer.order import in_order
from flexros.gap.answer.rivals.scale_doubt import covariance_of_answer, parameters_of_answer
from flexros.gap.answer.short_events import short_events
from flexros.gap.answer.unexplained_torques import hidden_from_torques
from flexros.gap.answer.warnings import answer_warnings, record_warnings, sensor_warnings
from flexros.gap.candidates.candidate import name_of
from flexros.gap.fit.estimates import determined, parameters_of, placed_effects
from flexros.gap.held_out.closed_share import closed_fraction
from flexros.gap.held_out.constant_speed import moving_on, moving_on_words
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor, tolerance_floor
from flexros.gap.held_out.gap_numbers import WHOLE, gap_numbers, settled, signal_gaps
from flexros.gap.held_out.predictions import prediction_of, signature_evidence
from flexros.gap.next_experiment.choose import file_or_name, next_experiment
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.result import DiagnosisResult, Explanation, RankedCandidate
from flexros.gap.schema import (
    BUDGET,
    GAINS,
    NEXT_EXPERIMENT,
    RIVALS,
    SHORT_EVENTS,
    SIZES,
    Cause,
    CauseParameter,
    Diagnosis,
)
from flexros.provenance import versions
from flexros.record.joint_signs import sign_words
from flexros.record.stamp_jitter import slight_last

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.answer.decision import Findings
    from flexros.gap.deadline import Deadline
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.held_out.closed_share import ClosedShare
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.progress import Stages
    from flexros.gap.schema import NextExperiment, Verdict
    from flexros.gap.settings import DiagnosisSettings
    from flexros.gap.where.find import Where

EXPLAINED = ("no_gap", "explained")
"""Verdicts that leave no doubt how the joints of a log count."""

STEP_ERROR = 1e-3
"""Relative standard deviation of a quantization step that is read off the levels of a log [1]."""


@dataclass(frozen=True, eq=False)
class HeldOutErrors:
    """Prediction errors in the held-out log, 0.1 s ahead.

    Attributes:
        before: Of the model as it was given, over the floor that it expects; with the numbers that it lacks where it
            predicts nothing without, or where no effect was found.
        nominal: Of the model with these numbers, over the same floor.
        after: Of the chosen explanation; None where nothing repairs the model.
        rival: Of the best other explanation; None where there is none.
        alone: Of single candidates, by effect@location.
        null: Of the model before, over the floor of the log.
        with_tolerance: The gap of torques that are off by their tolerance [1]; None where they are exact.
        moving_on: Motors that the chosen explanation predicts hardly better than at constant speed, by a much larger
            inertia.
    """

    before: AheadErrors
    nominal: AheadErrors
    after: AheadErrors | None
    rival: AheadErrors | None
    alone: Mapping[str, AheadErrors]
    null: AheadErrors
    with_tolerance: float | None = None
    moving_on: tuple[str, ...] = ()

    @property
    def worse(self) -> bool:
        """Whether the explanation predicts the held-out log worse than the nominal model: it repairs nothing."""
        return self.after is not None and self.after.mean > self.nominal.mean


def result_of(
    findings: Findings,
    null_prediction: PredictedLog,
    excess: Where | None,
    settings: DiagnosisSettings,
    stages: Stages,
    deadline: Deadline,
) -> DiagnosisResult:
    """Put the answer together.

    Args:
        findings: The fits of one log, checked on another.
        null_prediction: What the nominal model predicts of the fitted log.
        excess: Where the gap shows; None where that was not computed.
        settings: Settings of the diagnosis.
        stages: Progress of the diagnosis; its timings go into the result.
        deadline: What the search was cut short by. Without time no next experiment is chosen, and once that to finish
            in is over, what else the answer can do without is left out.
    """
    explanations, model = findings.explanations, findings.model
    with_rivals = not deadline.leaves_out(RIVALS)
    chosen, rival = explanations.chosen, best_rival(explanations) if with_rivals else None
    errors = _held_out_errors(findings, rival, with_alone=with_rivals)
    verdict = verdict_of(
        findings,
        (errors.after or errors.before).mean,
        errors.with_tolerance,
        worse=errors.worse,
        moving_on=bool(errors.moving_on),
        closed=_surely_closed(findings, errors),
    )
    whole = verdict != "no_gap"
    if whole and deadline.leaves_out(BUDGET):
        budget = Budget()
    else:
        budget = budget_of(findings, errors.before, errors.after or errors.before) if whole else without_gap(findings)
    patch = () if errors.worse else repair_of(findings)
    names, covariance = covariance_of_answer(findings)
    tolerated = chosen.predictor.tolerance
    closed = (_closed(errors.after, findings, errors) if patch else None) if whole else WHOLE
    found = [one.effect for one in placed_effects(chosen)] if verdict == "explained" and patch else None
    record, holdout = (settled(one.record, closed, found) for one in (findings.data, findings.held))
    of_records = record_warnings(record, holdout)
    before = _explanation(explanations.null, findings, null_prediction)
    after = _explanation(findings.repaired, findings) if patch else None
    probabilities = dict(zip(explanations.rivals, explanations.probabilities))
    return DiagnosisResult(
        diagnosis=_diagnosis(findings, verdict, errors, budget, excess, settings, stages, deadline, of_records),
        robot=model.robot,
        record=record,
        holdout=holdout,
        before=before,
        ranking=_ranking(findings, verdict, budget, 0 if deadline.leaves_out(GAINS) else findings.settings.confirmed),
        null_probability=float(probabilities[explanations.null]),
        after=after,
        rival=None if rival is None else _explanation(rival, findings),
        patch=patch,
        covariance_of=names,
        covariance=covariance if len(names) else None,
        excess=() if excess is None else excess.mapped,
        signals=signal_gaps(model.robot, errors.before, errors.after, errors.rival),
        signature_data=signature_evidence(model, findings.data, explanations.null, before, after),
        tolerance=dict(zip(tolerated.names, tolerated.by_name(chosen.deviations).tolist())),
        limits=identifiability_limits(findings.data.record, model.robot, findings.data.measurement.quantizations),
        settings=settings,
        timings=stages.timings,
    )


def _explanation(fit: CandidateFit, findings: Findings, fitted: PredictedLog | None = None) -> Explanation:
    """Predict both logs with a fitted model; `fitted` is its prediction of the fitted log where that is known."""
    return Explanation(
        name_of(fit.hypothesis),
        fitted or prediction_of(fit, findings.data),
        prediction_of(fit, findings.held),
        placed_effects(fit),
    )


def _held_out_errors(findings: Findings, rival: CandidateFit | None, *, with_alone: bool) -> HeldOutErrors:
    """Predict the held-out log with each model that the answer compares, once."""
    explanations, held, given = findings.explanations, findings.held, findings.as_given
    null = given.nominal
    rival = null if rival is explanations.null else rival
    repaired = explanations.detected or bool(findings.quantizations)
    compared = _compared(findings) if explanations.detected and with_alone else ()
    singles = {next(iter(fit.names)): fit for fit in reversed(explanations.rivals) if len(fit.hypothesis) == 1}
    before = given.fitted(given.kept) if explanations.detected else null
    alone = {name: singles[name] for fit in compared for name in fit.names if name in singles and before is null}
    fits = dict.fromkeys([null, before, findings.repaired, *([] if rival is None else [rival]), *alone.values()])
    errors = {fit: errors_ahead(fit, held) for fit in fits}
    after = errors[findings.repaired] if repaired else None
    stated = driven_model(findings.given, held.record).robot
    alike = [] if after is None else moving_on(findings.repaired, stated, held, errors[null], after)
    return HeldOutErrors(
        before=over_expected_floor(errors[before], findings.model, held),
        nominal=over_expected_floor(errors[null], findings.model, held),
        after=after,
        rival=None if rival is None else errors[rival],
        alone={name: errors[fit] for name, fit in alone.items()},
        null=errors[before],
        with_tolerance=tolerance_floor(findings.repaired, held),
        moving_on=hidden_from_torques(alike, findings),
    )


def _diagnosis(
    findings: Findings,
    verdict: Verdict,
    errors: HeldOutErrors,
    budget: Budget,
    excess: Where | None,
    settings: DiagnosisSettings,
    stages: Stages,
    deadline: Deadline,
    of_records: tuple[str, ...],
) -> Diagnosis:
    """Put together what is written into diagnosis.json."""
    sample_time = findings.held.record.sample_time
    gap = gap_numbers(errors.before, errors.after, sample_time, errors.rival, errors.with_tolerance)
    warnings = (
        *moving_on_words(errors.moving_on),
        *answer_warnings(findings, gap, worse=errors.worse),
        *(() if deadline.leaves_out(SHORT_EVENTS) else short_events(findings, gap)),
        *(() if verdict in EXPLAINED else sign_words(findings.data.record, findings.held.record)),
        *of_records,
        *sensor_warnings(findings),
    )
    following = _next(findings, verdict, stages, deadline) if settings.next_experiment else None
    return Diagnosis(
        schema=2,
        verdict=verdict,
        causes=_causes(findings, verdict, errors, budget, exact=not deadline.leaves_out(SIZES)),
        ambiguity_groups=groups_of(findings.explanations, findings.settings, findings.elsewhere),
        where=() if excess is None else excess.locations,
        gap=gap,
        budget=budget.shares,
        waterfall=budget.waterfalls,
        unexplained=budget.unexplained,
        model_numbers=budget.model_numbers,
        tolerance_sensitivity=findings.names_by_tolerance,
        next_experiment=following,
        partial=deadline.partial,
        warnings=slight_last(tuple(dict.fromkeys(warnings))),
        provenance={
            "log": findings.data.record.name,
            "holdout": findings.held.record.name,
            "robot": findings.model.robot.name,
            "robot_hash": findings.given.robot.model_hash,
            **versions(),
            **settings.model_dump(mode="json"),
            **findings.tolerance,
        },
    )


def _compared(findings: Findings) -> tuple[CandidateFit, ...]:
    """List the chosen explanation and its rivals."""
    explanations = findings.explanations
    return (explanations.chosen, *rivals_of(explanations, findings.settings, findings.elsewhere))


def _causes(
    findings: Findings, verdict: Verdict, errors: HeldOutErrors, budget: Budget, *, exact: bool
) -> tuple[Cause, ...]:
    """List the effects of the chosen explanation and of its rivals.

    An effect closes what it closes alone: fitted alone, or else added first as the budget has it.
    """
    explanations = findings.explanations
    added_first = {f"{one.effect}@{one.location}": one.share_first for one in budget.shares if one.effect}
    causes = {name: _rounding(name, findings, errors) for name in findings.quantized}
    if not explanations.detected:
        return tuple(causes.values())
    for fit in _compared(findings):
        for candidate, parameters in zip(fit.hypothesis, _sizes(fit, findings, exact=exact)):
            name = candidate.name
            if name not in causes:
                causes[name] = Cause(
                    effect=candidate.effect.name,
                    location=candidate.location,
                    probability=probability_of(name, findings, verdict),
                    parameters=parameters,
                    determined=determined(candidate, parameters),
                    closed_fraction=_closed(errors.alone[name], findings, errors)
                    if name in errors.alone
                    else added_first.get(name),
                )
    ranked = [causes[name] for name in sorted(causes, key=lambda name: rank_key(name, findings, verdict))]
    return in_order(ranked, budget.shares, budget.waterfalls)


def _surely_closed(findings: Findings, errors: HeldOutErrors) -> float:
    """Return the lower end of the interval of the share that the explanation closes on held-out data, at least 0."""
    share = _closed_share(errors.after, findings, errors)
    return 0.0 if share is None else max(0.0, share.interval[0])


def _closed(after: AheadErrors | None, findings: Findings, errors: HeldOutErrors) -> float | None:
    """Return the share of the gap that a model closes on held-out data; None where the gap does not show there."""
    share = _closed_share(after, findings, errors)
    return None if share is None else share.value


def _closed_share(after: AheadErrors | None, findings: Findings, errors: HeldOutErrors) -> ClosedShare | None:
    return None if after is None else closed_fraction(errors.before, after, findings.held.record.sample_time)


def _rounding(name: str, findings: Findings, errors: HeldOutErrors) -> Cause:
    """State the rounding of an encoder, which is read off the log."""
    located, quantization = effect_location(name), findings.quantized[name]
    unit = findings.model.robot.motors[quantization.motor].position_unit
    step = CauseParameter(value=quantization.step, std=STEP_ERROR * quantization.step, unit=unit)
    return Cause(
        effect=located.effect,
        location=located.location,
        probability=1.0,
        parameters={"step": step},
        closed_fraction=_closed(errors.null, findings, errors),
    )


def _ranking(findings: Findings, verdict: Verdict, budget: Budget, confirmed: int) -> tuple[RankedCandidate, ...]:
    """List every effect in its explanation, as many as are to be confirmed with their gain in the held-out log."""
    fits = _candidates(findings, verdict)
    ranked = sorted(fits, key=lambda one: rank_key(f"{one.effect}@{one.location}", findings, verdict))
    return tuple(
        replace(one, holdout_gain=held_out_gain(fits[one], findings)) if index < confirmed else one
        for index, one in enumerate(in_order(ranked, budget.shares, budget.waterfalls))
    )


def _candidates(findings: Findings, verdict: Verdict) -> dict[RankedCandidate, CandidateFit]:
    """List every effect with its explanation: the chosen one, whose sizes the patch has, else the most probable one."""
    explanations, comparison = findings.explanations, findings.explanations.comparison
    best: dict[str, tuple[RankedCandidate, CandidateFit]] = {}
    explained = zip(explanations.rivals, explanations.probabilities)
    for fit, probability in sorted(explained, key=lambda pair: pair[0] is not explanations.chosen):
        if fit.names <= best.keys():
            continue
        exact = probability > findings.settings.likely
        for candidate, parameters in zip(fit.hypothesis, _sizes(fit, findings, exact=exact)):
            if candidate.name in best:
                continue
            others = (other.name for other in fit.hypothesis if other is not candidate)
            ranked = RankedCandidate(
                effect=candidate.effect.name,
                location=candidate.location,
                parameters=parameters,
                gain=comparison.gain(fit),
                penalty=comparison.penalty(fit),
                probability=probability_of(candidate.name, findings, verdict),
                remainder=comparison.remainder(fit),
                together_with=tuple(effect_location(other) for other in others),
            )
            best[candidate.name] = (ranked, fit)
    return dict(best.values())


def _sizes(fit: CandidateFit, findings: Findings, *, exact: bool) -> list[dict[str, CauseParameter]]:
    """Return the parameters of every effect of an explanation; with exact errors, or quick ones of unlikely fits."""
    if fit is findings.explanations.chosen:
        return parameters_of_answer(findings)
    return findings.sizes(fit) if exact else parameters_of(fit)


def _next(findings: Findings, verdict: Verdict, stages: Stages, deadline: Deadline) -> NextExperiment | None:
    """Choose the experiment that separates the remaining explanations, unless the time is over."""
    deadline.begin(NEXT_EXPERIMENT)
    torques = findings.model.robot.commands == "torque"  # which the experiments command
    if verdict != "ambiguous" or not torques or deadline.stops():
        return None
    survivors = [placed_effects(fit) for fit in _compared(findings)]
    model, noise = findings.model, findings.data.measurement.deviation
    if not np.all(model.robot.encoder_noise > 0):  # the experiments have the noise of the log
        model = replace(model, robot=model.robot.with_values({"encoder_noise": float(np.median(noise))}))
    return next_experiment(
        model,
        survivors,
        name=file_or_name(findings.given.robot),
        sample_time=findings.data.record.sample_time,
        tool_measured=findings.data.tool is not None,
        tolerance=findings.tolerance,
        prescribed=findings.data.record.prescribed,
        settings=findings.data.settings,
        progress=lambda share: stages.inner(NEXT_EXPERIMENT, share),
        stop=deadline.stops,
    )
