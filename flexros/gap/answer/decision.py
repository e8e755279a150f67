"""What was found in a log: verdict, rivals, groups, probabilities, and how far the gap shrinks."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect
from flexros.effects.encoder_quantization import EncoderQuantization
from flexros.gap.candidates.candidate import name_of
from flexros.gap.fit.estimates import placed
from flexros.gap.held_out.prediction_gap import closed_fraction, errors_ahead, gap_numbers
from flexros.gap.held_out.predictions import prediction_of
from flexros.gap.held_out.rounding import over_expected_floor, unknown_rounding
from flexros.gap.held_out.signal_gaps import signal_gaps
from flexros.gap.result import Explanation
from flexros.gap.schema import EffectLocation
from flexros.gap.search.forward_selection import RIVAL
from flexros.gap.search.model_probability import FORM_ELSEWHERE, ModelComparison, evidence_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.held_out.prediction_gap import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import SignalGap
    from flexros.gap.schema import GapNumbers, Verdict
    from flexros.gap.search.forward_selection import Explanations
    from flexros.record.quantization import Quantization

PART_OF_UNKNOWN = 0.1
"""How often the best known effect is part of a gap that it does not explain [1] (development seeds: 3 of 39)."""


@dataclass(frozen=True, eq=False)
class Findings:
    """What was found in a log, with the log that was set aside.

    Attributes:
        model: The nominal model.
        data: The log that was fitted to.
        held: The log that was set aside.
        explanations: All fits.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; those of the robot file where left out.
    """

    model: RobotWithEffects
    data: FitData
    held: FitData
    explanations: Explanations
    tolerance: Mapping[str, float] = field(default_factory=dict)
    _errors: dict[CandidateFit, AheadErrors] = field(default_factory=dict, init=False)
    _held_fits: dict[CandidateFit, CandidateFit] = field(default_factory=dict, init=False)

    def explanation(self, one: CandidateFit) -> Explanation:
        """Predict both logs with a fitted model."""
        return Explanation(
            name_of(one.predictor.hypothesis), prediction_of(one, self.data), prediction_of(one, self.held), placed(one)
        )

    @cached_property
    def verdict(self) -> Verdict:
        """The answer in a word."""
        found = self.explanations
        if not found.detected:
            if doubted(found.evidence, self.data).significant(found.chosen) or self.held_out_gap:
                return "unknown_effect"
            return "explained" if self.quantized else "no_gap"
        elsewhere = self._on_held(found.chosen)
        if not (found.evidence.adequate(found.chosen) and self._held_evidence.adequate(elsewhere, FORM_ELSEWHERE)):
            return "unknown_effect"
        return "ambiguous" if len(self.rivals) else "explained"

    @cached_property
    def held_out_gap(self) -> bool:
        """Whether the nominal model leaves more than noise in the held-out log."""
        return doubted(self._held_evidence, self.held).significant(self._held_evidence.nothing)

    @cached_property
    def held_out_left(self) -> float:
        """Share of the gap that the explanation leaves in the held-out log [1]."""
        return self._held_evidence.left(self._on_held(self.explanations.chosen))

    def held_gain(self, one: CandidateFit) -> float:
        """Return twice the gain in log-likelihood over the nominal model in the held-out log; -inf if it runs away."""
        held = self._on_held(one)
        return self._held_evidence.gain(held) if np.isfinite(held.chi2) else -np.inf

    @cached_property
    def _held_evidence(self) -> ModelComparison:
        """The nominal model on the held-out log."""
        nothing = self._on_held(self.explanations.evidence.nothing)
        return evidence_of(self.held, nothing)

    def _on_held(self, one: CandidateFit) -> CandidateFit:
        """Take the sum of squares of a fit from the held-out log, with the numbers of the fitted one."""
        if one not in self._held_fits:
            residual = self.held.residuals(one.predictor, one.theta[:, None])
            squares = float(np.sum(residual**2))
            self._held_fits[one] = replace(one, chi2=squares if np.isfinite(squares) else np.inf)
        return self._held_fits[one]

    @cached_property
    def quantized(self) -> tuple[Quantization, ...]:
        """Encoders whose rounding matters and is not in the nominal model."""
        return unknown_rounding(self.model, self.data.measurement)

    @cached_property
    def quantized_by_name(self) -> dict[str, Quantization]:
        """The same by effect and place."""
        names = self.model.robot.joint_names
        return {f"{EncoderQuantization.name}@{names[one.motor]}": one for one in self.quantized}

    @cached_property
    def rivals(self) -> tuple[CandidateFit, ...]:
        """Explanations within a factor of the chosen one, with other effects."""
        found = self.explanations
        if not found.detected:
            return ()
        of_chosen = dict(zip(found.rivals, found.probabilities))[found.chosen]
        return tuple(
            one
            for one, probability in zip(found.rivals, found.probabilities)
            if one is not found.chosen and probability * RIVAL >= of_chosen
        )

    @cached_property
    def best_rival(self) -> CandidateFit | None:
        """The best explanation with other effects than the chosen one."""
        found = self.explanations
        if not found.detected:
            return None
        return next((one for one in found.rivals if one is not found.chosen), None)

    def groups(self) -> tuple[tuple[EffectLocation, ...], ...]:
        """Collect effects that stand for one another in rival explanations."""
        mine = {candidate.name: candidate for candidate in self.explanations.chosen.predictor.hypothesis}
        groups: dict[str, list[EffectLocation]] = {}
        for rival in self.rivals:
            theirs = {candidate.name: candidate for candidate in rival.predictor.hypothesis}
            for name in mine.keys() - theirs.keys():
                group = groups.setdefault(name, [place_of(mine[name].name)])
                group += [
                    place_of(other) for other in sorted(theirs.keys() - mine.keys()) if place_of(other) not in group
                ]
        return tuple(tuple(group) for group in groups.values() if len(group) > 1)

    def probability(self, name: str) -> float:
        """Add up the probabilities of all explanations that contain an effect at a place.

        Where none explains the gap, it is the probability that the effect is a part of it all the same.
        """
        pairs = zip(self.explanations.rivals, self.explanations.probabilities)
        among = sum(p for one, p in pairs if name in one.names)
        return float(min(1.0, among) * (PART_OF_UNKNOWN if self.verdict == "unknown_effect" else 1.0))

    def order(self, name: str) -> tuple[float, float, float]:
        """Order effects at places: by probability to the hundredth, then by what is lost without them.

        What is lost is the rise of the mean squared prediction error when the chosen explanation does without it; for
        the rounding of an encoder, of which a lattice leaves no doubt, its variance over that of the noise.
        """
        rounded = self.quantized_by_name.get(name)
        if rounded is not None:
            return -1.0, -(rounded.step**2) / 12 / float(self.model.robot.encoder_noise[rounded.motor]) ** 2, -1.0
        found, level = self.explanations, self.explanations.evidence.level
        rest = found.chosen.names - {name}
        without = min(level(one) for one in found.rivals if one.names <= rest)
        lost = without - level(found.chosen) if name in found.chosen.names else 0.0
        probability = self.probability(name)
        return -round(probability, 2), -lost, -probability

    def errors(self, one: CandidateFit) -> AheadErrors:
        """Predict the held-out log a tenth of a second ahead with a fitted model."""
        if one not in self._errors:
            self._errors[one] = errors_ahead(one, self.held)
        return self._errors[one]

    @cached_property
    def patch(self) -> tuple[PlacedEffect, ...]:
        """The effects that repair the model."""
        names = self.model.robot.joint_names
        rounding = tuple(PlacedEffect(EncoderQuantization(step=one.step), names[one.motor]) for one in self.quantized)
        return (*placed(self.explanations.chosen), *rounding)

    @cached_property
    def errors_before(self) -> AheadErrors:
        """Errors of the nominal model on held-out data, over the floor that it expects."""
        return over_expected_floor(self.errors(self.explanations.evidence.nothing), self.model, self.held)

    @cached_property
    def signals(self) -> tuple[SignalGap, ...]:
        """The gap of each motor in its own unit, on held-out data."""
        chosen = self.explanations.chosen if self.patch else None
        after, rival = (None if one is None else self.errors(one) for one in (chosen, self.best_rival))
        return signal_gaps(self.model.robot, self.errors_before, after, rival)

    def closed(self, one: CandidateFit) -> float | None:
        """Compute the share of the gap that a model closes on held-out data; None where the gap does not show there."""
        share = closed_fraction(self.errors_before, self.errors(one), self.held.record.sample_time)
        return None if share is None else share.value

    @cached_property
    def gap(self) -> GapNumbers:
        """How far the gap shrinks on held-out data."""
        repaired = self.explanations.detected or self.quantized
        after = self.errors(self.explanations.chosen) if repaired else None
        rival = self.errors(self.best_rival) if repaired and self.best_rival is not None else None
        return gap_numbers(self.errors_before, after, self.held.record.sample_time, rival)


def doubted(evidence: ModelComparison, data: FitData) -> ModelComparison:
    """Allow for noise that is a little other than declared: alone it is no gap."""
    return replace(evidence, floor_error=float(np.hypot(evidence.floor_error, data.measurement.doubt)))


def place_of(name: str) -> EffectLocation:
    """Split the name of a candidate, effect@location."""
    effect, _, location = name.partition("@")
    return EffectLocation(effect=effect, location=location)
