"""The fit of the nominal model: nothing but what is known with a tolerance only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.least_squares import FIT, CandidateFit, fit
from flexros.gap.prediction.predictor import Predictor

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import FitSettings


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

    def predictor(self, hypothesis: Hypothesis) -> Predictor:
        """Build the predictor of a hypothesis for the same log and tolerance."""
        return _predictor(self.data, self.model, hypothesis, self.fit.predictor.tolerance)


def fit_null(data: FitData, model: RobotWithEffects, tolerance: Tolerance, settings: FitSettings = FIT) -> NullFit:
    """Fit the nominal model, whose tolerated deviations alone are free.

    Args:
        data: Log and weights.
        model: The nominal model.
        tolerance: Parameters of the robot that are known with a tolerance only.
        settings: Settings of the fit.
    """
    predictor = _predictor(data, model, (), tolerance)
    null = fit(predictor, data, np.zeros(predictor.n_fitted), settings.null_iterations, settings=settings)
    if data.tool is not None and predictor.n_fitted:
        data = data.with_tool_frame_of(predictor, null.theta)
        null = fit(predictor, data, null.theta, settings.null_iterations, settings=settings)
    return NullFit(model, data, null)


def _predictor(data: FitData, model: RobotWithEffects, hypothesis: Hypothesis, tolerance: Tolerance) -> Predictor:
    record = data.record
    return Predictor(model, hypothesis, tolerance, record.sample_time, measured_torque=record.measured_torque)
