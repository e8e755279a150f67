"""From findings to the answer: causes, ranking, warnings, and all of it put together."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from flexros.effects.encoder_quantization import EncoderQuantization
from flexros.gap.answer.decision import place_of
from flexros.gap.answer.limits import cannot_tell
from flexros.gap.fit.estimates import covariance_of, parameters_of, placed
from flexros.gap.held_out.predictions import signature_evidence
from flexros.gap.next_experiment.choose import next_experiment
from flexros.gap.result import DiagnosisResult, RankedCandidate
from flexros.gap.schema import Cause, CauseParameter, Diagnosis
from flexros.gap.search.forward_selection import LIKELY
from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.answer.decision import Findings
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.progress import Stages
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import Explanation
    from flexros.gap.schema import NextExperiment
    from flexros.gap.where.find import Where
    from flexros.record.quantization import Quantization

CONFIRMED = 5
"""Effects, the first of the ranking, whose gain in the held-out log is computed, a second each at most (chosen)."""
STEP_ERROR = 1e-3
"""Relative standard deviation of a step that is read off a lattice [1] (chosen)."""


def result_of(
    found: Findings,
    before: Explanation,
    places: Where | None,
    settings: Mapping[str, Any],
    stages: Stages,
) -> DiagnosisResult:
    """Put the answer together.

    Args:
        found: What was found.
        before: The nominal model and what it predicts.
        places: Where the gap shows; None where it was not looked for.
        settings: Settings of the diagnosis.
        stages: Told how far the answer is; its timings go into the result.
    """
    explanations, evidence = found.explanations, found.explanations.evidence
    chosen = explanations.chosen
    rival = found.best_rival
    names, covariance = covariance_of(chosen, found.data)
    after = found.explanation(chosen) if found.patch else None
    tolerated = chosen.theta[chosen.predictor.n_effect :]
    return DiagnosisResult(
        diagnosis=_diagnosis(found, places, settings, stages),
        robot=found.model.robot,
        record=found.data.record,
        holdout=found.held.record,
        before=before,
        ranking=_ranking(found),
        nothing=next(
            float(p) for one, p in zip(explanations.rivals, explanations.probabilities) if one is evidence.nothing
        ),
        after=after,
        rival=None if rival is None else found.explanation(rival),
        patch=found.patch,
        covariance_of=names,
        covariance=covariance if len(names) else None,
        excess=() if places is None else places.mapped,
        signals=found.signals,
        evidence=signature_evidence(found.model, found.data, evidence.nothing, before, after),
        tolerance={name: float(value) for name, value in zip(chosen.predictor.tolerance.names, tolerated)},
        cannot_tell=cannot_tell(found),
        settings=settings,
        timings=stages.timings,
    )


def _diagnosis(found: Findings, places: Where | None, settings: Mapping[str, Any], stages: Stages) -> Diagnosis:
    """Put together what is written into diagnosis.json."""
    return Diagnosis(
        schema=1,
        verdict=found.verdict,
        causes=_causes(found),
        ambiguity_groups=found.groups(),
        where=() if places is None else places.locations,
        gap=found.gap,
        next_experiment=_next(found, stages) if settings.get("next_experiment") else None,
        warnings=tuple(dict.fromkeys((*_of_logs(found), *_of_sensors(found.data), *_warnings(found)))),
        provenance={
            "log": found.data.record.name,
            "holdout": found.held.record.name,
            "robot": found.model.robot.name,
            "robot_hash": found.model.robot.model_hash,
            **versions(),
            **dict(settings),
        },
    )


def _causes(found: Findings) -> tuple[Cause, ...]:
    """List the effects of the chosen explanation and of its rivals."""
    explanations = found.explanations
    causes = {name: _rounding(found, one) for name, one in found.quantized_by_name.items()}
    if not explanations.detected:
        return tuple(causes.values())
    for one in (explanations.chosen, *found.rivals):
        numbers = parameters_of(one, found.data)
        for candidate, parameters in zip(one.predictor.hypothesis, numbers):
            if candidate.name not in causes:
                alone = next((single for single in explanations.rivals if single.names == {candidate.name}), None)
                causes[candidate.name] = Cause(
                    effect=candidate.effect.name,
                    location=candidate.location,
                    probability=found.probability(candidate.name),
                    parameters=parameters,
                    closed_fraction=None if alone is None else found.closed(alone),
                )
    return tuple(causes[name] for name in sorted(causes, key=found.order))


def _rounding(found: Findings, one: Quantization) -> Cause:
    """State the rounding of an encoder, which is read off the log."""
    robot = found.model.robot
    return Cause(
        effect=EncoderQuantization.name,
        location=robot.joint_names[one.motor],
        probability=1.0,
        parameters={
            "step": CauseParameter(
                value=one.step, std=STEP_ERROR * one.step, unit=robot.motors[one.motor].position_unit
            )
        },
        closed_fraction=found.closed(found.explanations.evidence.nothing),
    )


def _ranking(found: Findings) -> tuple[RankedCandidate, ...]:
    """List every effect in its best explanation, the first few with the gain where they were not fitted."""
    ranked = sorted(_candidates(found), key=lambda pair: found.order(f"{pair[0].effect}@{pair[0].location}"))
    return tuple(
        replace(one, holdout_gain=found.held_gain(fit)) if place < CONFIRMED else one
        for place, (one, fit) in enumerate(ranked)
    )


def _candidates(found: Findings) -> list[tuple[RankedCandidate, CandidateFit]]:
    """List every effect with its best explanation."""
    explanations, evidence = found.explanations, found.explanations.evidence
    best: dict[str, tuple[RankedCandidate, CandidateFit]] = {}
    for one, probability in zip(explanations.rivals, explanations.probabilities):
        if all(candidate.name in best for candidate in one.predictor.hypothesis):
            continue
        numbers = parameters_of(one, found.data if probability > LIKELY else None)
        for candidate, parameters in zip(one.predictor.hypothesis, numbers):
            if candidate.name in best:
                continue
            others = tuple(place_of(other.name) for other in one.predictor.hypothesis if other is not candidate)
            ranked = RankedCandidate(
                effect=candidate.effect.name,
                location=candidate.location,
                parameters=parameters,
                gain=evidence.gain(one),
                penalty=evidence.penalty(one),
                probability=found.probability(candidate.name),
                remainder=evidence.left(one),
                beside=others,
            )
            best[candidate.name] = (ranked, one)
    return list(best.values())


def _next(found: Findings, stages: Stages) -> NextExperiment | None:
    """Choose the experiment that separates the explanations that are left."""
    if found.verdict != "ambiguous":
        return None
    survivors = [placed(one) for one in (found.explanations.chosen, *found.rivals)]
    return next_experiment(
        found.model,
        survivors,
        tool_measured=found.data.tool is not None,
        tolerance=found.tolerance,
        progress=lambda share: stages.inner("next experiment", share),
    )


def _of_logs(found: Findings) -> list[str]:
    """Give the warnings of the log, and those that only the held-out one has."""
    fitted, held = found.data.record.warnings, found.held.record.warnings
    return [*fitted, *(f"held-out log: {text}" for text in held if text not in fitted)]


def _of_sensors(data: FitData) -> tuple[str, ...]:
    """Give the warnings of encoders and tool tracker."""
    return data.measurement.warnings if data.tool is None else (*data.measurement.warnings, *data.tool.warnings)


def _warnings(found: Findings) -> list[str]:
    """Say what limits the answer."""
    explanations = found.explanations
    left = explanations.left
    warnings = []
    if explanations.detected and left > 0 and explanations.evidence.adequate(explanations.chosen):
        warnings.append(f"the explanation leaves {100 * left:.2g} % of the gap in the fitted log, more than noise does")
    gap = found.gap
    if gap.closed_fraction is not None and gap.closed_fraction < 0.5 and gap.before > 2:
        warnings.append(
            f"on held-out data the explanation closes only {100 * gap.closed_fraction:.0f} % of the gap: it may not "
            "hold beyond the fitted log"
        )
    return warnings
