"""Errors of further sensors in predictions some time ahead."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.residuals.sensor_data import SensorData
    from flexros.record.further_sensors import SensorRecord

MOST_BEFORE = 50
"""Most samples before the end of a prediction in which a value of a slow sensor is looked for (chosen)."""


@dataclass(frozen=True, eq=False)
class SensorsAhead:
    """Errors of further sensors at the ends of predictions.

    Attributes:
        errors: Measured minus predicted values without their offset; NaN where a prediction ends without a value,
            shape (n_starts, n_channels).
        floor: Their standard deviation without a gap, shape (n_channels,).
        sensors: The sensors that have a value at the end of any prediction.
    """

    errors: FloatArray
    floor: FloatArray
    sensors: tuple[SensorRecord, ...]


def last_samples(sensors: SensorData, horizon: int) -> int:
    """Return the number of samples up to the end of a prediction in which every sensor has a value, as far as allowed.

    Args:
        sensors: The sensors.
        horizon: Prediction horizon [samples].
    """
    longest = max(float(np.median(np.diff(one.sample + one.share))) for one in sensors.channels)
    return 1 + min(int(np.ceil(longest)), MOST_BEFORE, horizon)


def sensors_ahead(
    predictor: Predictor,
    parameters: FloatArray,
    data: FitData,
    states: FloatArray,
    ahead: FloatArray,
    ends: IntArray,
    horizon: int,
) -> SensorsAhead:
    """Compare further sensors with predictions that end at some samples.

    Each prediction is compared with the last value up to its end, at the time of that value. The offset of a sensor is
    its mean error in predictions one sample ahead.

    Args:
        predictor: Predictor of the model.
        parameters: Its parameters in the units of the fit, shape (n_fitted,).
        data: The log.
        states: Corrected states of all samples, shape (n, n_states, 1).
        ahead: Predicted states at the last samples up to each end, shape (n_starts, last, n_states).
        ends: Samples at which the predictions end, shape (n_starts,).
        horizon: Prediction horizon [samples].
    """
    sensors = data.sensors
    assert sensors is not None
    theta, record, last = parameters[:, None], data.record, ahead.shape[1]
    outputs = []
    for place in range(last):
        at, samples = np.ascontiguousarray(ahead[:, place])[:, :, None], ends + place + 1 - last
        outputs.append(predictor.sensor_outputs(sensors.wanted, theta, record, at, samples)[:, :, 0])
    motors = ahead[:, :, list(sensors.motor_rows)] * np.array([one.deflection for one in sensors.channels])
    predictions = np.stack(outputs, axis=1) - motors
    now = sensors.errors(predictor, theta, record, states)
    errors, floor = np.full((len(ends), len(sensors.channels)), np.nan), []
    for place, one in enumerate(sensors.channels):
        offset = float(np.mean(now[place][one.used, 0]))
        times = one.sample + one.share
        value = np.searchsorted(times, ends, side="right") - 1
        row = times[np.maximum(value, 0)] - (ends + 1 - last)  # among the last samples
        found = np.flatnonzero((value >= 0) & (row >= 0) & one.used[np.maximum(value, 0)])
        before = np.minimum(row[found].astype(np.int64), last - 1)
        after, share = np.minimum(before + 1, last - 1), row[found] - before
        predicted = (1 - share) * predictions[found, before, place] + share * predictions[found, after, place]
        error = one.measured[value[found]] - predicted - offset
        errors[found, place] = np.where(np.isfinite(error), error, np.inf)
        variance = data.gain.variance_ahead(horizon, one.readout[None])[0]
        floor.append(float(np.sqrt(max(variance, 0.0) + one.noise**2)))
    kept = np.flatnonzero((~np.isnan(errors)).any(axis=0))
    return SensorsAhead(errors[:, kept], np.array(floor)[kept], tuple(sensors.channels[k].sensor for k in kept))
