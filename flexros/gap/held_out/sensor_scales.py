"""Further sensors that follow a model by another scale: their calibration, or an effect that it lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

OFF, FOLLOWS = 0.1, 0.95
"""Deviation of the scale of a sensor that is told, and least correlation with what a model predicts [1] (chosen)."""


def sensor_scale_words(fit: CandidateFit, data: FitData) -> tuple[str, ...]:
    """Say which sensors read another multiple of what a fitted model predicts.

    Args:
        fit: The model.
        data: The log.
    """
    sensors = data.sensors
    if sensors is None:
        return ()
    theta, states = fit.theta[:, None], fit.states(data)[:, :, None]
    words = []
    for channel, error in zip(sensors.channels, sensors.errors(fit.predictor, theta, data.record, states), strict=True):
        measured = channel.measured[channel.used]
        predicted = measured - error[channel.used, 0]
        variance, covariance = np.var(predicted), float(np.cov(measured, predicted, bias=True)[0, 1])
        if not variance > 0 or covariance < FOLLOWS * np.sqrt(variance * np.var(measured)):
            continue
        scale = covariance / variance
        if abs(scale - 1) > OFF:
            words.append(
                f"{channel.sensor.name} reads {scale:.3g} times what the model predicts there: check its calibration, "
                "or the model lacks something that acts on it"
            )
    return tuple(words)
