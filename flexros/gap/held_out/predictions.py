"""Predictions of a log that the report needs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.signatures.signature_data import SignatureData
from flexros.gap.where.prediction_errors import SensorErrors
from flexros.record.record import ToolRecord

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.result import Explanation
    from flexros.robot import Robot

SEEN_BY_TOOL = 1e-3
"""Least rms of a tool error that is not floating-point rounding, over the noise of the tracker [1] (chosen)."""


def prediction_of(fit: CandidateFit, data: FitData) -> PredictedLog:
    """Predict a log with a fitted model; the log may be another one than the model was fitted to."""
    predicted = data.predict(fit.predictor, fit.theta[:, None], record_states=True)
    assert predicted.states is not None
    # copies of one lane, so that the arrays of all lanes are freed
    states = predicted.states[:, : 2 * fit.predictor.robot.n_coordinates, 0].copy()
    innovations = predicted.innovation[:, :, 0] * data.record.predicted
    return PredictedLog(innovations, data.gain.spread, states, int(np.argmax(data.settled)))


def tool_errors(fit: CandidateFit, data: FitData) -> tuple[ToolRecord, FloatArray] | None:
    """Compute the tool errors of a fitted model, with frame and offset of the tracker projected out.

    Args:
        fit: The fitted model.
        data: The log that it was fitted to.

    Returns:
        The measurement at its times, and measured minus predicted positions [m], shape (n_t, 3), zero where the error
        is floating-point rounding; None where the tool was not measured.
    """
    tool = data.tool
    if tool is None:
        return None
    end = data.spread.size + tool.position.size
    residual = data.residuals(fit.predictor, fit.theta[:, None])[data.spread.size : end, 0]
    error = tool.spread * residual.reshape(-1, 3)
    error[:, np.sqrt(np.mean(error**2, axis=0)) < SEEN_BY_TOOL * tool.spread] = 0.0
    return ToolRecord((tool.samples[tool.row] + tool.share) * data.record.sample_time, tool.position), error


def sensor_errors(fit: CandidateFit, data: FitData) -> tuple[SensorErrors, ...]:
    """Return the weighted errors of further sensors under a fitted model, without their offsets.

    Args:
        fit: The fitted model.
        data: The log that it was fitted to.
    """
    sensors = data.sensors
    if sensors is None:
        return ()
    begin = data.spread.size + (0 if data.tool is None else data.tool.position.size)
    residual = fit.residual(data)[begin : begin + sensors.size]  # errors of torques come after them
    parts = np.split(residual, np.cumsum([len(one.measured) for one in sensors.channels])[:-1])
    return tuple(SensorErrors(one.sensor, part, one.used) for one, part in zip(sensors.channels, parts, strict=True))


def signature_evidence(
    model: RobotWithEffects, data: FitData, nothing: CandidateFit, before: Explanation, after: Explanation | None
) -> SignatureData:
    """Collect the data that the pictures of the signatures are computed from.

    Args:
        model: The nominal model.
        data: The log that was fitted.
        nothing: The fit without any effect.
        before: The nominal model with its predictions.
        after: The repaired model with its predictions; None where no effect was found.
    """
    repaired = None if after is None else _with_friction(model.with_effects(after.effects))
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


def _with_friction(model: RobotWithEffects) -> Robot:
    """Return a robot with the viscous friction of its laws as its own, which acts in its linear model too."""
    friction: dict[str, float] = {}
    for law in model.laws:
        if isinstance(law.effect, ViscousFriction):
            name = f"{law.location}.viscous_friction"
            friction[name] = friction.get(name, model.robot.parameters[name].value) + law.effect.coefficient
    return model.robot.with_values(friction)
