"""Further sensors prepared for a fit: their errors, whitened, with unknown offsets projected out.

Beside the motor encoders a log may hold link-side encoders, strain gauges, joint torque sensors, an accelerometer and a
gyroscope. The observer is corrected by the motor encoders alone; the sensors are compared with what its states predict.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.residuals.sensor_channel import SensorChannel, fast_length_covering
from flexros.gap.residuals.sensor_doubts import doubt_of
from flexros.gap.residuals.sensor_noise import error_spectrum, variance_error, white_noise
from flexros.record.further_sensors import FEWEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.prediction.predictor import Predictor
    from flexros.prediction.observer import ObserverGain
    from flexros.record.further_sensors import SensorRecord
    from flexros.record.record import Record

UNKNOWN = 1e3
"""Prior standard deviation of an offset over the extent of the signal, large enough to project it out [1] (chosen)."""
LEAST_NOISE = 1e-6
"""Least noise of a sensor over the extent of its signal, for values without any [1] (chosen)."""
AT_SAMPLE = 1e-3
"""Share of a sample time up to which a value belongs to a sample [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class SensorData:
    """Further sensors of a log.

    Attributes:
        channels: The channels that are used.
        motor_rows: Row of the motor position in the state for each, length n_channels.
        warnings: Warnings, one sentence each.
    """

    channels: tuple[SensorChannel, ...]
    motor_rows: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    @property
    def wanted(self) -> tuple[tuple[str, int], ...]:
        """Quantity and number of motor or axis of each channel."""
        return tuple((one.sensor.quantity, one.sensor.index) for one in self.channels)

    @property
    def size(self) -> int:
        """Number of all values."""
        return sum(len(one.measured) for one in self.channels)

    @property
    def used(self) -> BoolArray:
        """Which values are used, shape (size,)."""
        return np.concatenate([np.zeros(0, dtype=bool), *(one.used for one in self.channels)])

    @property
    def n_values(self) -> int:
        """Number of values that are used, without those that unknown offsets cost."""
        return int(self.used.sum()) - round(sum(float(np.sum(one.removed)) for one in self.channels))

    @property
    def floor_error(self) -> float:
        """Relative standard deviation of the mean noise variance, zero where all noise is declared [1]."""
        errors = [one.noise_error * len(one.measured) for one in self.channels]
        return float(np.linalg.norm(errors)) / max(self.size, 1)

    @cached_property
    def samples(self) -> IntArray:
        """Samples at which the outputs of the model are needed, increasing, shape (n_p,)."""
        rows = [row for one in self.channels for row in (one.sample, one.sample + (one.share > 0))]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))

    def errors(self, predictor: Predictor, thetas: FloatArray, record: Record, states: FloatArray) -> list[FloatArray]:
        """Compute the errors of every channel under a hypothesis.

        Args:
            predictor: The hypothesis.
            thetas: Parameters, shape (n_fitted, sets).
            record: The log, or its first part.
            states: Predicted states of its samples, shape (n, n_states, lanes).

        Returns:
            Measured minus predicted values, shape (m, sets) each; predictions after the first part count as zero.
        """
        samples = self.samples
        inside = samples[samples < len(states)]
        kept = states if len(inside) == len(states) else states[inside]
        outputs = predictor.sensor_outputs(self.wanted, thetas, record, kept, inside)
        lanes = slice(thetas.shape[1])
        outputs, motors = (
            _padded(outputs[:, :, lanes], samples),
            _padded(kept[:, list(self.motor_rows), lanes], samples),
        )
        return [
            one.measured[:, None] - one.predicted(outputs[:, place], motors[:, place], samples)
            for place, one in enumerate(self.channels)
        ]

    def weighted(self, errors: Sequence[FloatArray]) -> FloatArray:
        """Weigh the errors of all channels, one after the other, shape (size, sets)."""
        return np.vstack([one.weighted(error) for one, error in zip(self.channels, errors, strict=True)])


def _padded(values: FloatArray, samples: IntArray) -> FloatArray:
    """Append zeros to the values of the first samples, shape (n_p, n_channels, sets)."""
    lacking = len(samples) - len(values)
    return np.concatenate([values, np.zeros((lacking, *values.shape[1:]))]) if lacking else values


def sensor_data(
    record: Record,
    gain: ObserverGain,
    measurement: Measurement,
    counted: BoolArray,
    nominal: Predictor,
    states: FloatArray,
    most: int,
) -> SensorData:
    """Prepare the further sensors of a log; those that contradict the model by sign or unit are left out.

    Args:
        record: The log.
        gain: Gain of the observer.
        measurement: Noise of the encoders; with its tolerance for measured machines.
        counted: Samples that are used, shape (n,).
        nominal: Predictor of the nominal model.
        states: States that it predicts, shape (n, n_states, lanes).
        most: Largest number of values of all sensors together.
    """
    thin = max(1, -(-sum(len(sensor.time) for sensor in record.sensors) // most))
    robot, every = nominal.robot, np.arange(record.n_samples)
    wanted = [(sensor.quantity, sensor.index) for sensor in record.sensors]
    outputs = nominal.sensor_outputs(wanted, np.zeros((0, 1)), record, states, every)[:, :, 0]
    rest = robot.equilibrium(motor_position=np.median(record.position, axis=0))
    readout, states = nominal.model.sensor_slopes(wanted, rest), states[:, :, 0]
    channels, rows, warnings = [], [], []
    for place, measured in enumerate(record.sensors):
        sensor = measured.every(thin)
        motor = 0 if sensor.of_tool else robot.motor_rows[sensor.index]
        channel = _channel(sensor, record, counted)
        row = readout[place].copy()
        row[motor] -= 1.0 if channel.deflection else 0.0
        predicted = channel.predicted(outputs[:, place, None], states[:, motor, None], every)[:, 0]
        if channel.used.sum() < FEWEST:
            warnings.append(
                f"{sensor.name}: {channel.used.sum()} values are where the log is used, {FEWEST} are needed"
            )
            continue
        declared = robot.sensor_noise(sensor.quantity)
        noise = _noise(channel, predicted) if declared is None else declared
        channel = replace(channel, noise_error=variance_error(len(predicted)) if declared is None else 0.0)
        doubt = doubt_of(channel, predicted, noise, record, robot)
        if doubt is not None:
            warnings.append(doubt.text)
            if doubt.contradicts:
                continue
        channels.append(_weighed(channel, record, gain, measurement, predicted, noise, row))
        rows.append(motor)
    return SensorData(tuple(channels), tuple(rows), tuple(warnings))


def _channel(sensor: SensorRecord, record: Record, counted: BoolArray) -> SensorChannel:
    """Place the values of a sensor among the samples, and choose what of a link position is compared.

    A strain gauge measures how far the link is from the motor, and the log holds it with the noise of the motor encoder
    added; of link and deflection the one with less noise is compared.
    """
    at = sensor.time / record.sample_time
    at = np.where(np.abs(at - np.round(at)) < AT_SAMPLE, np.round(at), at)
    sample = np.minimum(at.astype(np.int64), record.n_samples - 1)
    empty = np.zeros(0)
    share = np.where(sample < record.n_samples - 1, at - sample, 0.0)
    link = SensorChannel(
        sensor, False, sensor.values, sample, share, 0.0, empty, counted[sample], empty, empty[:, None], empty
    )
    if sensor.motor is None:
        return link
    deflection = replace(link, deflection=True, measured=sensor.values - sensor.motor)
    noise = [float(np.std(np.diff(one.measured, 4))) for one in (link, deflection)]
    return deflection if noise[1] < noise[0] else link


def _noise(channel: SensorChannel, predicted: FloatArray) -> float:
    """Return the noise of a sensor as the log shows it."""
    found = white_noise(channel.measured - predicted, channel.measured)
    return max(found, LEAST_NOISE * float(np.std(channel.measured)))


def _weighed(
    channel: SensorChannel,
    record: Record,
    gain: ObserverGain,
    measurement: Measurement,
    predicted: FloatArray,
    noise: float,
    readout: FloatArray,
) -> SensorChannel:
    """Add weights to a channel, and what is unknown of the sensor: its offset; of a real one scale and clock too."""
    tolerance, extent = measurement.signal_tolerance, float(np.std(channel.measured))
    signal = channel.measured if channel.sensor.motor is None else channel.sensor.values - channel.sensor.motor
    deviation = float(np.hypot(noise, tolerance * np.std(signal)))
    step = float(np.median(np.diff(channel.sensor.time))) / record.sample_time
    length = fast_length_covering(len(predicted))
    turns = np.arange(length // 2 + 1) / length
    spectrum = error_spectrum(gain, readout, deviation, max(round(step), 1), turns)
    weighed = replace(channel, noise=deviation, readout=readout, whitening=1.0 / np.sqrt(spectrum))
    directions = [np.full(len(predicted), UNKNOWN * max(extent, deviation))]
    if tolerance:
        directions += [tolerance * (predicted - predicted.mean()), 0.5 * np.gradient(predicted)]
    return weighed.with_unknown(directions)
