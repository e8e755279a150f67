"""The prediction errors of a log, as the views see them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.where.bands import OctaveBands, fast_length_within
from flexros.gap.where.channel import Channel
from flexros.gap.where.motion import motion_of
from flexros.gap.where.regimes import regimes

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.settings import WhereSettings
    from flexros.record.further_sensors import SensorRecord
    from flexros.record.record import Record
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class SensorErrors:
    """Prediction errors of one channel of a further sensor.

    Attributes:
        sensor: The measurement, shape (m,).
        errors: Whitened errors in standard deviations of their noise, shape (m,).
        valid: Values that are used, shape (m,).
    """

    sensor: SensorRecord
    errors: FloatArray
    valid: BoolArray


@dataclass(frozen=True, eq=False)
class PredictionErrors:
    """Prediction errors of the nominal model in a log of n samples and M motors.

    Attributes:
        prediction: The predictions, with the filtered states where these were kept.
        record: The log; `valid` holds only samples with a finite prediction error.
        robot: The nominal robot.
        noise_spectrum: Spectrum of the prediction errors without a gap, shape (any, M).
        tool_error: Measured minus predicted tool positions [m], shape (n_t, 3); None where there are none.
        settings: Settings of the search.
        sensors: Prediction errors of further sensors.
    """

    prediction: PredictedLog
    record: Record
    robot: Robot
    noise_spectrum: FloatArray
    tool_error: FloatArray | None
    settings: WhereSettings
    sensors: tuple[SensorErrors, ...] = ()

    @cached_property
    def motors(self) -> tuple[Channel, ...]:
        """The positions of the predicted motors; the first samples are left out for a fast Fourier transform."""
        record, settings = self.record, self.settings
        scaled = self.prediction.innovations / np.maximum(self.prediction.sd, 1e-300)
        motion = motion_of(record, self.robot, self.prediction.states)
        n = fast_length_within(record.n_samples)
        bands = OctaveBands.of(n, record.sample_time, settings.lowest_hz)
        valid = (record.valid & (np.arange(record.n_samples) >= self.prediction.first))[-n:]
        return tuple(
            Channel(
                joint,
                scaled[-n:, motor],
                bands,
                {name: mask[-n:] for name, mask in regimes(motion, motor, record.sample_time).items()},
                valid,
                self.noise_spectrum[:, motor],
                settings,
                estimate_level=settings.floor == "estimated",
                rotor=(motion.rotor_angle[-n:, motor], motion.speed[-n:, motor]),
            )
            for motor, joint in enumerate(self.robot.joint_names)
            if record.predicted[motor]
        )
