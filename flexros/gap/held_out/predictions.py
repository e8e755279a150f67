"""What models predict of a log, kept for the report."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import place_effects
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.signatures.signature_data import SignatureData
from flexros.record.record import ToolRecord

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import Explanation

SEEN_BY_TOOL = 1e-3
"""Least rms of a tool error that is more than rounding, over the noise of the tracker [1] (chosen)."""


def prediction_of(one: CandidateFit, data: FitData) -> PredictedLog:
    """Predict a log with a fitted model.

    Args:
        one: The fitted model.
        data: The log; it need not be the one that the model was fitted to.
    """
    found = data.predict(one.predictor, one.theta[:, None], record_states=True)
    assert found.states is not None
    states = found.states[:, : 2 * one.predictor.robot.n_coordinates, 0].copy()  # keep one lane of the whole arrays
    return PredictedLog(found.innovation[:, :, 0].copy(), data.gain.spread, states, int(np.argmax(data.settled)))


def tool_errors(one: CandidateFit, data: FitData) -> tuple[ToolRecord, FloatArray] | None:
    """Compute how far the tool is from where a fitted model has it, frame and offset of the tracker taken off.

    Args:
        one: The fitted model.
        data: The log that it was fitted to.

    Returns:
        What the tracker saw, at the times at which it looked, and measured minus predicted positions [m], shape
        (n_t, 3), zero where the error is but rounding; None where the tool was not measured.
    """
    tool = data.tool
    if tool is None:
        return None
    residual = data.residuals(one.predictor, one.theta[:, None])[data.spread.size :, 0]
    error = tool.spread * residual.reshape(-1, 3)
    error[:, np.sqrt(np.mean(error**2, axis=0)) < SEEN_BY_TOOL * tool.spread] = 0.0
    return ToolRecord((tool.samples[tool.place] + tool.share) * data.record.sample_time, tool.position), error


def signature_evidence(
    model: RobotWithEffects, data: FitData, nothing: CandidateFit, before: Explanation, after: Explanation | None
) -> SignatureData:
    """Collect what the pictures of the effects' signatures are computed from.

    Args:
        model: The nominal model.
        data: The log that was fitted to.
        nothing: The fit without any effect.
        before: The nominal model with its predictions.
        after: The repaired model with its predictions; None where nothing was found.
    """
    repaired = None if after is None else place_effects(model.robot, after.effects).robot
    tool, error = tool_errors(nothing, data) or (data.record.tool, None)
    return SignatureData(
        robot=model.robot,
        record=replace(data.record, tool=tool),
        observer=data.gain,
        before=before.fit,
        after=None if after is None else after.fit,
        repaired=repaired,
        tool_error=error,
    )
