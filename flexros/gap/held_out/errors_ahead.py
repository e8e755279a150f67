"""Errors of predictions 0.1 s ahead, over their floor."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.held_out.sensors_ahead import last_samples, sensors_ahead
from flexros.gap.settings import PredictionGapSettings

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.further_sensors import SensorRecord

HORIZON = 0.1
"""Prediction horizon [s] (the contract)."""
RUN_AWAY = 1e15
"""Error over the floor that a diverged prediction counts as [1] (chosen)."""


def samples_ahead(sample_time: float) -> int:
    """Return the samples of the horizon, at least one, of a log with a sample time [s]."""
    return max(1, round(HORIZON / sample_time))


@dataclass(frozen=True, eq=False)
class AheadErrors:
    """Squared errors of predictions 0.1 s ahead, over their variance by noise alone.

    Attributes:
        squares: Squared errors of the S signals, motor positions and then further sensors, each over its floor, shape
            (n_windows, S); of a sensor without a value there, its mean. Prescribed motors have none.
        starts: Samples at which the predictions start, shape (n_windows,).
        floor: Standard deviation of the errors without a gap [unit of the signal], shape (S,).
        floor_error: Relative standard deviation of the variance of the noise [1]; zero where it is as declared.
        settings: Settings that the errors were computed with.
        sensors: The further sensors.
        prescribed: Motors whose motion is prescribed.
    """

    squares: FloatArray
    starts: IntArray
    floor: FloatArray
    floor_error: float = 0.0
    settings: PredictionGapSettings = field(default_factory=PredictionGapSettings)
    sensors: tuple[SensorRecord, ...] = ()
    prescribed: tuple[int, ...] = ()

    @property
    def mean(self) -> float:
        """The gap E: mean over windows and signals; 1 without a gap."""
        return float(self.squares.mean())

    def over(self, floor: FloatArray) -> AheadErrors:
        """Refer the errors to another floor [unit of the signal], shape (S,)."""
        return replace(self, squares=self.squares * (self.floor / floor) ** 2, floor=floor)

    def of_joint(self, motor: int, n_motors: int) -> list[int]:
        """List the signals of the joint of a motor; those of the tool belong to the last one.

        Args:
            motor: Number of the motor.
            n_motors: Number of motors M.
        """
        joints = [n_motors - 1 if sensor.of_tool else sensor.index for sensor in self.sensors]
        begin = n_motors - len(self.prescribed)
        return [*self.of_motor(motor), *(begin + place for place, joint in enumerate(joints) if joint == motor)]

    def of_motor(self, motor: int) -> list[int]:
        """List the signal of the position of a motor; none where its motion is prescribed.

        Args:
            motor: Number of the motor.
        """
        return [] if motor in self.prescribed else [motor - sum(other < motor for other in self.prescribed)]

    def rms(self, signal: int) -> float:
        """Return the root mean square of the errors of a signal [its unit]."""
        return float(self.floor[signal] * np.sqrt(self.squares[:, signal].mean()))


@dataclass(frozen=True, eq=False)
class SignedErrors:
    """Errors of predictions 0.1 s ahead, with their signs.

    Attributes:
        errors: Errors of the S signals, motor positions and then further sensors, over their standard deviation by
            noise alone, shape (n_windows, S); NaN of a sensor without a value there. Prescribed motors have none.
        starts: Samples at which the predictions start, shape (n_windows,).
        floor: That standard deviation [unit of the signal], shape (S,).
        sensors: The further sensors.
    """

    errors: FloatArray
    starts: IntArray
    floor: FloatArray
    sensors: tuple[SensorRecord, ...] = ()

    @property
    def limited(self) -> FloatArray:
        """The errors, those of a diverged prediction at a limit, as those of a sensor without a value there."""
        return np.asarray(np.where(np.abs(self.errors) < RUN_AWAY, self.errors, RUN_AWAY))

    @property
    def squares(self) -> FloatArray:
        """Squared errors, those of a diverged prediction limited; of a sensor without a value there, their mean."""
        squares = self.limited**2
        for column in range(squares.shape[1] - len(self.sensors), squares.shape[1]):
            lost = np.isnan(self.errors[:, column])
            squares[lost, column] = squares[~lost, column].mean()
        return np.asarray(squares)


def errors_ahead(fit: CandidateFit, data: FitData) -> AheadErrors:
    """Compute the squared errors of predictions 0.1 s ahead that start throughout a log.

    Args:
        fit: The model.
        data: The log, usually another one than the model was fitted to.

    Raises:
        InputError: The log is too short.
    """
    (errors,) = errors_ahead_of(fit.predictor, fit.theta[:, None], data)
    return errors


def errors_ahead_of(predictor: Predictor, thetas: FloatArray, data: FitData) -> list[AheadErrors]:
    """Compute the squared errors of predictions 0.1 s ahead with up to `LANES` sets of parameters.

    Args:
        predictor: Predictor of the model.
        thetas: Parameters in the units of the fit, shape (n_fitted, sets).
        data: The log.

    Raises:
        InputError: The log is too short.
    """
    settings = data.settings.prediction_gap
    return [
        AheadErrors(
            signed.squares,
            signed.starts,
            signed.floor,
            data.floor_error,
            settings,
            signed.sensors,
            data.record.prescribed,
        )
        for signed in signed_errors_ahead(predictor, thetas, data, settings.spacing)
    ]


def signed_errors_ahead(predictor: Predictor, thetas: FloatArray, data: FitData, spacing: float) -> list[SignedErrors]:
    """Compute the errors of predictions 0.1 s ahead that start throughout a log, with some sets of parameters.

    Args:
        predictor: Predictor of the model.
        thetas: Parameters in the units of the fit, shape (n_fitted, sets), up to `LANES` of them.
        data: The log.
        spacing: Time between the starts of two predictions [s].

    Raises:
        InputError: The log is too short.
    """
    record = data.record
    horizon = samples_ahead(record.sample_time)
    prediction = data.predict(predictor, thetas, record_states=True)
    assert prediction.states is not None
    first = max(int(np.argmax(data.settled)), predictor.loop.line_length)
    starts = np.arange(first, record.n_samples - horizon, max(1, round(spacing / record.sample_time)))
    counts = np.concatenate([[0], np.cumsum(~data.counted)])
    whole = starts[counts[starts + horizon + 1] == counts[starts]]
    # a log with losses everywhere has no window without losses; then only both ends must be valid
    starts = whole if len(whole) else starts[data.counted[starts] & data.counted[starts + horizon]]
    if not len(starts):
        raise InputError(
            f"{record.name}: there is no stretch of {HORIZON:g} s after the first {first * record.sample_time:.3g} s, "
            f"which the predictor needs to settle; the log has {record.duration:.3g} s, record a longer one"
        )
    predicted = record.predicted
    floor = data.gain.ahead(horizon)[predicted]
    last = 0 if data.sensors is None else last_samples(data.sensors, horizon)
    found = []
    for lane, theta in enumerate(thetas.T):
        states = prediction.states[:, :, lane : lane + 1]
        ahead = predictor.ahead(theta, record, states[:, :, 0], starts, horizon, last=last)
        errors = (record.position[starts + horizon] - ahead.positions)[:, predicted] / floor
        one = SignedErrors(errors, starts, floor)
        if ahead.states is not None:
            further = sensors_ahead(predictor, theta, data, states, ahead.states, starts + horizon, horizon)
            one = SignedErrors(
                np.hstack([errors, further.errors / further.floor]),
                starts,
                np.concatenate([floor, further.floor]),
                further.sensors,
            )
        found.append(one)
    return found
