"""The fit of the nominal model: nothing but what is known with a tolerance only."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.tolerance import FARTHER, FARTHEST
from flexros.gap.fit.least_squares import FIT, fit
from flexros.gap.fit.linearisation import linearise
from flexros.gap.prediction.compiled_plant import LANES, compiled_plant
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.prepare_fit_data import with_tool_frame_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import FitSettings
    from flexros.prediction.integration_step import IntegrationSteps


@dataclass(frozen=True, eq=False)
class NullFit:
    """The nominal model, fitted to a log.

    Attributes:
        model: The nominal model.
        data: Log and weights; the frame of a tool tracker is estimated with the fitted model.
        fit: The fit without any effect.
    """

    model: RobotWithEffects
    data: FitData
    fit: CandidateFit

    def predictor(self, hypothesis: Hypothesis, plant: CompiledPlant | None = None) -> Predictor:
        """Build the predictor of a hypothesis for the same log and tolerance.

        Args:
            hypothesis: The hypothesis.
            plant: A plant that may hold its laws already.
        """
        return predictor_for(self.data, self.model, hypothesis, self.fit.predictor.tolerance, plant)

    def farther(self) -> NullFit:
        """Return the same, beside which tolerated numbers go farther in fits of effects."""
        predictor = self.fit.predictor
        farther = replace(predictor.tolerance, farthest=FARTHER)
        return replace(self, fit=replace(self.fit, predictor=predictor.with_tolerance(farther)))

    def plant(
        self, candidates: Sequence[Candidate], *, rough: bool = False, steps: IntegrationSteps | None = None
    ) -> CompiledPlant:
        """Compile a plant for all hypotheses that contain no other candidates than these.

        Args:
            candidates: The candidates.
            rough: Whether its predictions are compared with each other alone, see `CompiledPlant`.
            steps: Integration steps; None: those that are needed.
        """
        tolerance, record = self.fit.predictor.tolerance, self.data.record
        return compiled_plant(
            self.model,
            tuple(candidates),
            tolerance.names,
            record.sample_time,
            measured_torque=record.measured_torque,
            rough=rough,
            steps=steps,
        )


def fit_null(
    data: FitData,
    model: RobotWithEffects,
    tolerance: Tolerance,
    settings: FitSettings = FIT,
    start: FloatArray | None = None,
    stop: Callable[[], bool] | None = None,
) -> NullFit:
    """Fit the nominal model, whose tolerated deviations alone are free.

    Of many tolerated parameters only the directions are fitted, in this and all further fits, in which the log informs:
    a rigid arm of six joints has 54 parameters, and a log informs in about 20 directions.

    Args:
        data: Log and weights.
        model: The nominal model.
        tolerance: Parameters of the robot that are known with a tolerance only.
        settings: Settings of the fit.
        start: Tolerated deviations of the parameters to begin with [1], shape (n_names,); default: none.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    predictor = predictor_for(data, model, (), tolerance)
    enough, most = max(settings.enough, data.negligible), settings.null_iterations
    share = settings.enough_of_rest if data.record.premises.floor_is_noise else 0.0
    first = np.zeros(predictor.n_fitted) if start is None else start
    if len(tolerance.names) >= LANES:
        slopes = linearise(predictor, data, first).slopes
        tolerance = tolerance.informed(slopes.T @ slopes / data.misfit)
        predictor, first = predictor_for(data, model, (), tolerance), tolerance.along(first)
    null = fit(predictor, data, first, most, enough=enough, share=share, settings=settings, stop=stop)
    if data.tool is not None and predictor.n_fitted:
        data = with_tool_frame_of(data, predictor, null.theta)
        null = fit(predictor, data, null.theta, most, enough=enough, share=share, settings=settings, stop=stop)
    return NullFit(model, data, null)


def predicting_best(null: CandidateFit, data: FitData, stop: Callable[[], bool] | None = None) -> CandidateFit:
    """Fit the tolerated deviations of the nominal model to predicted positions alone, whatever torques that takes.

    The gap before a repair is that of the nominal model at its best, as `flexros gap` measures it. Where errors of the
    torques count, friction that it lacks would pull its parameters away from there.

    Args:
        null: The nominal model, fitted to all errors.
        data: Log and weights.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    if data.torques is None:
        return null
    settings, data = data.settings.fit, data.without_torques
    enough = max(settings.enough, data.negligible)
    most = settings.final_iterations
    predictor = null.predictor.with_tolerance(replace(null.predictor.tolerance, farthest=FARTHEST))
    return fit(predictor, data, null.theta, most, enough=enough, settings=settings, stop=stop)


def predictor_for(
    data: FitData,
    model: RobotWithEffects,
    hypothesis: Hypothesis,
    tolerance: Tolerance,
    plant: CompiledPlant | None = None,
) -> Predictor:
    """Build the predictor of a log under a hypothesis.

    Args:
        data: The log.
        model: The nominal model.
        hypothesis: Effects in addition to it.
        tolerance: Parameters of the robot that may deviate.
        plant: The same model compiled with more candidates; it is used where it covers the hypothesis.
    """
    record = data.record
    return Predictor(
        model, hypothesis, tolerance, record.sample_time, measured_torque=record.measured_torque, plant=plant
    )
