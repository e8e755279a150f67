"""The nominal model as it was given: without the numbers that it lacks, or with some of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.gap.candidates.tolerance import FARTHEST
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.null_fit import predicting_best, predictor_for
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.held_out.errors_ahead import errors_ahead, samples_ahead
from flexros.gap.prediction.driven_model import driven_model

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.answer.decision import Findings
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData


SKILL = 0.5
"""Errors of a motor 0.1 s ahead, over those of a prediction that it stays where it is, from which on a model predicts
nothing there [1] (chosen): it leaves more than a quarter of the variance of the motion."""
HOPELESS = 2.0
"""The same with the deviations of the nominal model, from which on its own predict nothing either [1] (chosen): fits
lowered errors to 0.39 of that at least (two arms without rotors)."""


@dataclass(frozen=True, eq=False)
class GivenModel:
    """The nominal model as it was given, with some of the rotors and the load that it lacks.

    Viscous friction of its file that only calms a simulator is left out always, as it would stop joints without rotors.

    Attributes:
        findings: Fits of one log.
    """

    findings: Findings
    _plants: dict[tuple[Hypothesis, bool], CompiledPlant] = field(default_factory=dict)
    _fits: dict[frozenset[str], CandidateFit] = field(default_factory=dict)

    @cached_property
    def lacking(self) -> frozenset[str]:
        """The numbers that it lacks, as effects at their locations, e.g. "rotor_inertia@motor_1"."""
        unknown, tolerated = self.findings.unknown, self.findings.explanations.null.predictor.tolerance.names
        rotors = {f"{RotorInertia.name}@{motor}" for motor in unknown.inertias if f"{motor}.inertia" in tolerated}
        return frozenset(rotors if unknown.load is None else {*rotors, f"{ToolLoad.name}@tool"})

    @cached_property
    def nominal(self) -> CandidateFit:
        """The model with all these numbers and without any effect, as it predicts best."""
        return predicting_best(self.findings.explanations.null, self.findings.data, self.findings.stop)

    def model(self, numbers: Collection[str]) -> RobotWithEffects:
        """Return it with some of these numbers."""
        findings, unknown = self.findings, self.findings.unknown
        inertias = {k: v for k, v in unknown.inertias.items() if f"{RotorInertia.name}@{k}" in numbers}
        load = unknown.load if f"{ToolLoad.name}@tool" in numbers else None
        some = replace(unknown, inertias=inertias, load=load)
        return some.given_to(driven_model(findings.given, findings.data.record))

    def predictor(self, hypothesis: Hypothesis, numbers: Collection[str]) -> Predictor:
        """Return the predictor of effects on it with some of these numbers, in the parameters of all other fits.

        Rotors are parameters of the compiled plant, whose steps are short enough for the joints without any.
        """
        data, tolerance = self.findings.data, replace(self.nominal.predictor.tolerance, farthest=FARTHEST)
        key = hypothesis, f"{ToolLoad.name}@tool" in numbers

        def of(model: RobotWithEffects) -> Predictor:
            return predictor_for(data, model, hypothesis, tolerance, self._plants.get(key))

        if key not in self._plants:
            bare = {name for name in numbers if not name.startswith(f"{RotorInertia.name}@")}
            self._plants[key] = of(self.model(bare)).plant
        return of(self.model(numbers))

    @cached_property
    def kept(self) -> frozenset[str]:
        """The numbers without which it predicts nothing, so that the gap begins with them.

        A joint that lacks its rotor may fly off within 0.1 s, and all else would be a negligible share of such a gap.
        The motor that is predicted worst is given its rotor first; if that is not what it lacks, all numbers are kept.
        """
        kept: frozenset[str] = frozenset()
        while kept != self.lacking:
            strays = self._strays(replace(self.nominal, predictor=self.predictor((), kept)))
            if SKILL < strays.max() <= HOPELESS:
                strays = self._strays(self.fitted(kept))
            worst = int(np.argmax(strays))
            if strays[worst] <= SKILL:
                break
            rotor = f"{RotorInertia.name}@{self.findings.model.robot.joint_names[worst]}"
            kept = kept | {rotor} if rotor in self.lacking - kept else self.lacking
        return kept

    def _strays(self, fit: CandidateFit) -> FloatArray:
        """Return the errors of the motors over those of a prediction that they stay where they are, shape (M,) [1]."""
        return errors_over_rest(errors_ahead(fit, self.findings.held), self.findings.held)

    def fitted(self, numbers: Collection[str]) -> CandidateFit:
        """Return it with some of these numbers and without any effect, its tolerated deviations fitted to the log.

        They need not be finished: what lacks rotors falls by less and less, and leaves thousands of floors.
        """
        key, data = frozenset(numbers), self.findings.data.without_torques
        if key == self.lacking:
            return self.nominal
        if key not in self._fits:
            settings, predictor = data.settings.fit, self.predictor((), key)
            starts = np.stack([one.theta for one in (self.nominal, *self._fits.values())], axis=-1)
            self._fits[key] = fit(
                predictor,
                data,
                starts[:, int(np.argmin(chi2_of(predictor, data, starts)))],
                settings.joint_iterations,
                enough=max(settings.enough, data.negligible),
                share=settings.enough_of_rest,
                settings=settings,
                stop=self.findings.stop,
            )
        return self._fits[key]

    def deviations(self, numbers: Collection[str]) -> FloatArray:
        """Return the tolerated deviations of it with some of these numbers.

        Where it has those without which it predicts nothing, they are those of the nearer one of the model that the gap
        begins with and the nominal one: what lacks rotors is stiff to simulate, and a fit to each takes long.

        Args:
            numbers: The numbers.
        """
        some = frozenset(numbers)
        if not self.kept <= some:
            return self.fitted(some).deviations
        return self.fitted(self.kept if len(self.lacking - some) > len(some - self.kept) else self.lacking).deviations


def errors_over_rest(errors: AheadErrors, held: FitData) -> FloatArray:
    """Return the errors of the motors over those of a prediction that they stay where they are, rms, shape (M,) [1].

    Those of motors whose motion is prescribed are zero.

    Args:
        errors: Errors in a log.
        held: The log.
    """
    position = held.record.position
    moved = position[errors.starts + samples_ahead(held.record.sample_time)] - position[errors.starts]
    ratios: FloatArray = np.zeros(position.shape[1])
    for motor in range(position.shape[1]):
        for signal in errors.of_motor(motor):
            ratios[motor] = errors.rms(signal) / max(np.sqrt(np.mean(moved[:, motor] ** 2)), errors.floor[signal])
    return ratios
