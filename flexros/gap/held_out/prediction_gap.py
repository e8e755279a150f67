"""The gap between robot and model: errors of predictions 0.1 s ahead, over their floor."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.held_out.sensors_ahead import last_samples, sensors_ahead
from flexros.gap.result import SignalGap
from flexros.gap.schema import GapNumbers
from flexros.gap.settings import PredictionGapSettings
from flexros.random_streams import generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.further_sensors import SensorRecord
    from flexros.record.quantization import Quantization
    from flexros.record.record import Record
    from flexros.robot import Robot

METRIC = "mean squared prediction error 0.1 s ahead over its floor variance"
HORIZON = 0.1
"""Prediction horizon [s] (the contract)."""
BOOTSTRAP_STREAM = 20
"""Stream of random numbers of the bootstrap."""
SETTLES = 0.5
"""Closed share of the gap from which a repaired model explains the log, so that it is of this robot [1] (chosen)."""
RUN_AWAY = 1e15
"""Error over the floor that a diverged prediction counts as [1] (chosen)."""
_MILLI, _MICRO = 1e-3, 1e-6
_SMALL = 1e-4
"""Errors below this are stated in millionths, others in thousandths [rad or m] (chosen)."""


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
    def squares(self) -> FloatArray:
        """Squared errors, those of a diverged prediction limited; of a sensor without a value there, their mean."""
        squares = np.where(np.abs(self.errors) < RUN_AWAY, self.errors, RUN_AWAY) ** 2
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
    horizon = max(1, round(HORIZON / record.sample_time))
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


@dataclass(frozen=True)
class ClosedShare:
    """The share of a gap that a repair closes.

    Attributes:
        value: (E_before - E_after) / (E_before - 1), or such a difference of two repairs [1].
        interval: Its 95 % interval [1].
    """

    value: float
    interval: tuple[float, float]


def closed_fraction(before: AheadErrors, after: AheadErrors, sample_time: float) -> ClosedShare | None:
    """Compute the share of the gap that is closed, with a 95 % interval by a bootstrap over blocks of the log.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows.
        sample_time: Time between two samples [s].

    Returns:
        The share and its interval; None where the gap does not show in these errors.
    """
    return share_between(before, before, after, sample_time)


def share_between(before: AheadErrors, more: AheadErrors, less: AheadErrors, sample_time: float) -> ClosedShare | None:
    """Compute the share of a gap between two repairs, with a 95 % interval by a bootstrap over blocks of the log.

    (E_more - E_less) / (E_before - 1), all of the same log. A gap within the noise of the floor has no share, which
    would be a quotient of noise.

    Args:
        before: Errors of the nominal model.
        more: Errors of the model that leaves more, at the same windows.
        less: Errors of the one that leaves less.
        sample_time: Time between two samples [s].

    Returns:
        The share and its interval; None where the gap does not show in these errors.
    """
    settings = before.settings
    of_blocks = (before.starts * sample_time / settings.block).astype(int)
    blocks = np.unique(of_blocks)
    models = (before, more, less)
    sums = np.array([[errors.squares[of_blocks == block].mean() for block in blocks] for errors in models])
    counts = np.array([np.sum(of_blocks == block) for block in blocks], dtype=float)
    draws = generator(0, BOOTSTRAP_STREAM).integers(0, len(blocks), size=(settings.draws, len(blocks)))
    means = (sums * counts)[:, draws].sum(axis=-1) / counts[draws].sum(axis=-1)
    least = settings.shows * _sampling_error(before)
    if before.mean - 1.0 <= least:
        return None
    means = means[:, means[0] - 1.0 > least]
    low, high = np.quantile((means[1] - means[2]) / (means[0] - 1.0), [0.025, 0.975])
    return ClosedShare((more.mean - less.mean) / (before.mean - 1.0), (float(low), float(high)))


def tolerance_floor(fit: CandidateFit, held: FitData) -> float | None:
    """Return the gap E of a log whose torques are off by their tolerance; None where they are exact.

    The floor holds the tolerance t as white torque. An error of a real torque, by a torque constant or friction of
    slightly other form, lasts: then predictions stray farther. Here the torque of each motor deviates from its mean by
    the factor 1 + t, one motor after the other, with the same rms t:

        E = 1 + sum over motors of mean((prediction with its torque off - prediction)^2 / floor^2).

    Numbers of the robot with a tolerance are fitted, so that they leave nothing.

    Args:
        fit: The model.
        held: The log.
    """
    share, record = held.measurement.signal_tolerance, held.record
    if not share:
        return None
    spacing, theta = held.settings.prediction_gap.spacing, fit.theta[:, None]
    (as_recorded,) = signed_errors_ahead(fit.predictor, theta, held, spacing)
    total = 1.0
    for motor in np.flatnonzero(record.predicted).tolist():
        change = np.zeros_like(record.torque)
        change[:, motor] = share * (record.torque[:, motor] - record.torque[:, motor].mean())
        off = replace(held, record=_with_torque(record, fit.predictor.robot, change))
        (errors,) = signed_errors_ahead(fit.predictor, theta, off, spacing)
        strayed = np.clip(errors.errors - as_recorded.errors, -RUN_AWAY, RUN_AWAY)
        total += float(np.nanmean(strayed**2))
    return total


def _with_torque(record: Record, robot: Robot, change: FloatArray) -> Record:
    """Add torques to those of a log [Nm or N], shape (n, M); to the positions of servos what causes such torques."""
    if record.command is None:
        return replace(record, torque=record.torque + change)
    stiffness = [robot.parameters[f"{name}.servo_stiffness"].value for name in robot.joint_names]
    return replace(record, command=record.command + change / np.array(stiffness))


def settled(record: Record, closed: float | None) -> Record:
    """Return a record without the warnings that doubt the nominal model, where a repair closes much of the gap.

    Args:
        record: The log.
        closed: Share of the gap that the repaired model closes [1]; None without one, or where no gap shows.
    """
    return record if closed is None or closed < SETTLES else record.without_doubts()


def gap_numbers(
    before: AheadErrors,
    after: AheadErrors | None,
    sample_time: float,
    rival: AheadErrors | None = None,
    with_tolerance: float | None = None,
) -> GapNumbers:
    """State the gap before and after a repair.

    Args:
        before: Errors of the nominal model.
        after: Errors of the repaired model, at the same windows; None where nothing was repaired.
        sample_time: Time between two samples [s].
        rival: Errors of the best explanation that was not chosen, None for none.
        with_tolerance: The gap of torques that are off by their tolerance [1]; None where they are exact.
    """
    share = None if after is None else closed_fraction(before, after, sample_time)
    return GapNumbers(
        metric=METRIC,
        unit="1",
        before=before.mean,
        after=None if after is None else after.mean,
        noise_floor=1.0,
        tolerance_floor=with_tolerance,
        best_rival=None if rival is None else rival.mean,
        closed_fraction=None if share is None else share.value,
        interval=None if share is None else share.interval,
    )


def _sampling_error(errors: AheadErrors) -> float:
    """Return the standard deviation of E without a gap, from noise and the error of the floor.

    Overlapping windows count as one, which is conservative: most of the error is noise of the last sample.
    """
    independent = max(errors.squares.size * errors.settings.spacing / HORIZON, 1.0)
    return float(np.hypot(np.sqrt(2.0 / independent), errors.floor_error))


def signal_gaps(
    robot: Robot, before: AheadErrors, after: AheadErrors | None = None, rival: AheadErrors | None = None
) -> tuple[SignalGap, ...]:
    """Return the root mean square of the prediction errors of each motor position and further sensor.

    Args:
        robot: The robot.
        before: Errors of the nominal model.
        after: Errors of the repaired model, None for none.
        rival: Errors of the best explanation that was not chosen, None for none.
    """
    motors = [motor for index, motor in enumerate(robot.motors) if index not in before.prescribed]
    signals = [(f"{motor.name} position", motor.position_unit) for motor in motors]
    signals += [(sensor.name, sensor.unit) for sensor in before.sensors]
    gaps = []
    for column, (name, unit) in enumerate(signals):
        scale, prefix = (_MICRO, "µ") if before.rms(column) < _SMALL else (_MILLI, "m")
        if column >= len(motors) and before.rms(column) >= 1.0:
            scale, prefix = 1.0, ""
        gaps.append(
            SignalGap(
                signal=f"{name}, 0.1 s ahead",
                unit=f"{prefix}{unit}",
                before=before.rms(column) / scale,
                after=None if after is None else after.rms(column) / scale,
                floor=float(before.floor[column]) / scale,
                rival=None if rival is None else rival.rms(column) / scale,
            )
        )
    return tuple(gaps)


def unknown_rounding(model: RobotWithEffects, measurement: Measurement) -> tuple[Quantization, ...]:
    """List the encoders whose quantization is coarse and not in the model."""
    known = {law.location for law in model.laws if law.effect.as_noise}
    names = model.robot.joint_names
    return tuple(one for one in measurement.quantizations if one.coarse and names[one.motor] not in known)


def over_expected_floor(errors: AheadErrors, model: RobotWithEffects, data: FitData) -> AheadErrors:
    """Refer prediction errors to the floor that a model expects, so that quantization that it lacks is a gap.

    Args:
        errors: Prediction errors over the floor of the log, quantization included.
        model: The model.
        data: The log.
    """
    unknown = unknown_rounding(model, data.measurement)
    if not unknown:
        return errors
    expected = np.array(data.measurement.deviation)
    for encoder in unknown:
        expected[encoder.motor] = model.robot.encoder_noise[encoder.motor]
    more = np.zeros_like(errors.floor)
    added = (expected**2 - data.measurement.deviation**2)[data.record.predicted]
    more[: len(added)] = added
    return errors.over(np.sqrt(errors.floor**2 + more))
