"""From fits to the answer: verdict, causes, groups, ranking and the numbers of the gap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from flexros.gap.cannot_tell import cannot_tell
from flexros.gap.diagnosis_file import Cause, Diagnosis, GapNumbers, Place
from flexros.gap.explain import RIVAL, UNEXPLAINED
from flexros.gap.fitted_numbers import covariance_of, parameters_of, placed
from flexros.gap.how_far import closed_fraction, errors_ahead
from flexros.gap.hypothesis import name_of
from flexros.gap.predictions import prediction_of, signature_evidence
from flexros.gap.result import Candidate, DiagnosisResult, Explanation
from flexros.gap.signal_gaps import signal_gaps
from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.diagnosis_file import Verdict
    from flexros.gap.explain import Explanations
    from flexros.gap.fit import Fit
    from flexros.gap.fit_data import FitData
    from flexros.gap.how_far import AheadErrors
    from flexros.gap.result import SignalGap
    from flexros.gap.where.find import Where

METRIC = "mean squared prediction error 0.1 s ahead over its floor variance"


@dataclass(frozen=True, eq=False)
class Findings:
    """What was found in a log, with the log that was set aside.

    Attributes:
        model: The nominal model.
        data: The log that was fitted to.
        held: The log that was set aside.
        explanations: All fits.
    """

    model: RobotWithEffects
    data: FitData
    held: FitData
    explanations: Explanations

    def explanation(self, one: Fit) -> Explanation:
        """Predict both logs with a fitted model."""
        return Explanation(
            name_of(one.predictor.hypothesis), prediction_of(one, self.data), prediction_of(one, self.held), placed(one)
        )

    @cached_property
    def verdict(self) -> Verdict:
        """The answer in a word."""
        found = self.explanations
        if not found.detected:
            return "unknown_effect" if found.evidence.significant(found.chosen) else "no_gap"
        if found.left > UNEXPLAINED:
            return "unknown_effect"
        return "ambiguous" if len(self._rivals) else "explained"

    @cached_property
    def _rivals(self) -> tuple[Fit, ...]:
        """Explanations within a factor of the chosen one, with other effects."""
        found = self.explanations
        if not found.detected:
            return ()
        of_chosen = dict(zip(map(id, found.rivals), found.probabilities))[id(found.chosen)]
        return tuple(
            one
            for one, probability in zip(found.rivals, found.probabilities)
            if one is not found.chosen and probability * RIVAL >= of_chosen
        )

    @cached_property
    def best_rival(self) -> Fit | None:
        """The best explanation with other effects than the chosen one."""
        found = self.explanations
        if not found.detected:
            return None
        return next((one for one in found.rivals if one is not found.chosen), None)

    def groups(self) -> tuple[tuple[Place, ...], ...]:
        """Collect effects that stand for one another in rival explanations."""
        mine = {suspect.name: suspect for suspect in self.explanations.chosen.predictor.hypothesis}
        groups: dict[str, list[Place]] = {}
        for rival in self._rivals:
            theirs = {suspect.name: suspect for suspect in rival.predictor.hypothesis}
            for name in mine.keys() - theirs.keys():
                group = groups.setdefault(name, [_place(mine[name].name)])
                group += [_place(other) for other in sorted(theirs.keys() - mine.keys()) if _place(other) not in group]
        return tuple(tuple(group) for group in groups.values() if len(group) > 1)

    def probability(self, name: str) -> float:
        """Add up the probabilities of all explanations that contain an effect at a place."""
        pairs = zip(self.explanations.rivals, self.explanations.probabilities)
        return float(
            min(1.0, sum(p for one, p in pairs if name in {suspect.name for suspect in one.predictor.hypothesis}))
        )

    @cached_property
    def errors_before(self) -> AheadErrors:
        """Errors of the nominal model on held-out data."""
        return errors_ahead(self.explanations.evidence.nothing, self.held)

    @cached_property
    def signals(self) -> tuple[SignalGap, ...]:
        """The gap of each motor in its own unit, on held-out data."""
        chosen = self.explanations.chosen if self.explanations.detected else None
        after, rival = (None if one is None else errors_ahead(one, self.held) for one in (chosen, self.best_rival))
        return signal_gaps(self.model.robot, self.errors_before, after, rival)

    def closed(self, one: Fit) -> float:
        """Compute the share of the gap that a model closes on held-out data."""
        share, _ = closed_fraction(self.errors_before, errors_ahead(one, self.held), self.held.record.sample_time)
        return share

    @cached_property
    def gap(self) -> GapNumbers:
        """How far the gap shrinks on held-out data."""
        before = self.errors_before
        if not self.explanations.detected:
            return GapNumbers(metric=METRIC, unit="1", before=before.mean, noise_floor=1.0)
        after = errors_ahead(self.explanations.chosen, self.held)
        share, interval = closed_fraction(before, after, self.held.record.sample_time)
        rival = None if self.best_rival is None else errors_ahead(self.best_rival, self.held).mean
        return GapNumbers(
            metric=METRIC,
            unit="1",
            before=before.mean,
            after=after.mean,
            noise_floor=1.0,
            best_rival=rival,
            closed_fraction=share,
            interval=interval,
        )


def result_of(
    found: Findings,
    before: Explanation,
    places: Where | None,
    settings: Mapping[str, Any],
    timings: Mapping[str, float],
) -> DiagnosisResult:
    """Put the answer together.

    Args:
        found: What was found.
        before: The nominal model and what it predicts.
        places: Where the gap shows; None where it was not looked for.
        settings: Settings of the diagnosis.
        timings: Time of every stage [s].
    """
    explanations, evidence = found.explanations, found.explanations.evidence
    chosen = explanations.chosen
    rival = found.best_rival
    names, covariance = covariance_of(chosen, evidence.level(chosen))
    after = found.explanation(chosen) if explanations.detected else None
    tolerated = chosen.theta[chosen.predictor.n_effect :]
    return DiagnosisResult(
        diagnosis=_diagnosis(found, places, settings),
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
        patch=placed(chosen),
        covariance_of=names,
        covariance=covariance if len(names) else None,
        excess=() if places is None else places.looked,
        signals=found.signals,
        evidence=signature_evidence(found.model, found.data, before, after),
        tolerance={name: float(value) for name, value in zip(chosen.predictor.tolerance.names, tolerated)},
        cannot_tell=cannot_tell(found),
        settings=settings,
        timings=timings,
    )


def _diagnosis(found: Findings, places: Where | None, settings: Mapping[str, Any]) -> Diagnosis:
    """Put together what is written into diagnosis.json."""
    return Diagnosis(
        schema=1,
        verdict=found.verdict,
        causes=_causes(found),
        ambiguity_groups=found.groups(),
        where=() if places is None else places.places,
        gap=found.gap,
        next_experiment=None,
        warnings=(*found.data.record.warnings, *_warnings(found)),
        provenance={"log": found.data.record.name, "robot": found.model.robot.name, **versions(), **dict(settings)},
    )


def _causes(found: Findings) -> tuple[Cause, ...]:
    """List the effects of the chosen explanation and of its rivals, by probability."""
    explanations = found.explanations
    if not explanations.detected:
        return ()
    causes: dict[str, Cause] = {}
    for one in (explanations.chosen, *found._rivals):
        numbers = parameters_of(one, explanations.evidence.level(one))
        for suspect, parameters in zip(one.predictor.hypothesis, numbers):
            if suspect.name not in causes:
                alone = next(
                    (
                        single
                        for single in explanations.rivals
                        if [s.name for s in single.predictor.hypothesis] == [suspect.name]
                    ),
                    None,
                )
                causes[suspect.name] = Cause(
                    effect=suspect.effect.name,
                    location=suspect.location,
                    probability=found.probability(suspect.name),
                    parameters=parameters,
                    closed_fraction=None if alone is None else found.closed(alone),
                )
    return tuple(sorted(causes.values(), key=lambda cause: -cause.probability))


def _ranking(found: Findings) -> tuple[Candidate, ...]:
    """List every effect in its best explanation."""
    explanations, evidence = found.explanations, found.explanations.evidence
    best: dict[str, Candidate] = {}
    for one in explanations.rivals:
        numbers = parameters_of(one, evidence.level(one)) if one.predictor.hypothesis else []
        for suspect, parameters in zip(one.predictor.hypothesis, numbers):
            if suspect.name in best:
                continue
            others = tuple(_place(other.name) for other in one.predictor.hypothesis if other is not suspect)
            best[suspect.name] = Candidate(
                effect=suspect.effect.name,
                location=suspect.location,
                parameters=parameters,
                gain=evidence.gain(one),
                penalty=evidence.penalty(one),
                probability=found.probability(suspect.name),
                remainder=evidence.left(one),
                beside=others,
            )
    return tuple(sorted(best.values(), key=lambda one: (-one.probability, -one.score)))


def _warnings(found: Findings) -> list[str]:
    """Say what limits the answer."""
    explanations = found.explanations
    left = explanations.left
    warnings = []
    if explanations.detected and 0 < left <= UNEXPLAINED:
        warnings.append(f"the explanation leaves {100 * left:.2g} % of the gap in the fitted log, more than noise does")
    gap = found.gap
    if gap.closed_fraction is not None and gap.closed_fraction < 0.5 and gap.before > 2:
        warnings.append(
            f"on held-out data the explanation closes only {100 * gap.closed_fraction:.0f} % of the gap: it may not "
            "hold beyond the fitted log"
        )
    return warnings


def _place(name: str) -> Place:
    effect, _, location = name.partition("@")
    return Place(effect=effect, location=location)
