"""A log prepared for a fit: observer gain, initial state and weights of its prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

from flexros.errors import InputError
from flexros.gap.noise.weights import measurement_of, spread_of
from flexros.gap.residuals.initial_state_errors import InitialStateErrors, initial_state_errors
from flexros.gap.residuals.lost_commands import check_enough_left, lost_commands
from flexros.gap.residuals.observed_model import NOTHING, ObservedModel
from flexros.gap.residuals.sensor_data import sensor_data
from flexros.gap.residuals.tool_data import tool_data, tracker_noise
from flexros.gap.residuals.tool_frame import FEWEST, usable_poses

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.compile.loop.prediction import LoopPrediction
    from flexros.effects import RobotWithEffects
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.line import Line
    from flexros.gap.residuals.observed_model import Beginning
    from flexros.gap.residuals.sensor_data import SensorData
    from flexros.gap.residuals.tool_data import ToolData
    from flexros.gap.residuals.torque_errors import TorqueErrors
    from flexros.gap.settings import DiagnosisSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record

RUN_AWAY = 1e6
"""Largest prediction error over the largest motion of the log; beyond it the prediction has diverged [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class FitData:
    """A log and what a fit needs to weigh its prediction errors.

    Attributes:
        record: The log.
        gain: Gain of the predictor.
        initial_state: State of the robot before the first sample, shape (2 n_coordinates,); of the lead-in where there
            is one.
        spread: Standard deviation of a prediction error without a gap [rad or m], shape (n, M); infinite where a sample
            was not measured, where an initial-state error or a lost command has not decayed, and for a motor whose
            motion is prescribed; larger where the torque of a lost command still matters.
        measurement: Noise of the encoders.
        settings: Settings of the diagnosis.
        level: Torque noise that the predictor allows for, relative: see `observer_gain` [1].
        from_rest: Whether the log begins at rest, in which case every model begins in its own equilibrium.
        lead_in: First part of a log that begins in motion, with the gain of the predictor that finds the state there;
            None for one that begins at rest.
        tool: Tool measurement; None where there is none.
        sensors: Further sensors; None where there are none, or none that is used.
        pose: Arm coordinates at which the gain was computed [rad or m], shape (N,); None for home.
        initial_state_errors: Effect of initial-state errors, which is projected out; None for a log that begins in
            motion, whose first samples are not used.
        nominal_level: Mean squared weighted prediction error of the motors by the nominal model, or by the explanation
            around which the log was weighed [1].
        misfit: Mean squared weighted prediction error that no candidate removes [1]: where a model leaves much more
            than noise, the prior of tolerated parameters weighs as much more.
        line: What acts at one frequency, which is projected out of the errors of the motors; None for nothing.
        torques: Errors of the torques of a measured log, which count as well; None where they tell no more.
        least_level: Torque noise that the predictor would allow for if the model were not far off [1]; infinite where
            that does not matter, as in logs of real machines.
    """

    record: Record
    gain: ObserverGain
    initial_state: FloatArray
    spread: FloatArray
    measurement: Measurement
    settings: DiagnosisSettings
    level: float
    from_rest: bool = False
    lead_in: tuple[Record, ObserverGain] | None = None
    tool: ToolData | None = None
    sensors: SensorData | None = None
    pose: FloatArray | None = None
    initial_state_errors: InitialStateErrors | None = None
    nominal_level: float = 1.0
    misfit: float = 1.0
    line: Line | None = None
    torques: TorqueErrors | None = None
    least_level: float = np.inf

    @property
    def counted(self) -> BoolArray:
        """Samples whose prediction errors are used, shape (n,)."""
        return np.asarray(self.record.valid & np.all(np.isfinite(self.spread[:, self.record.predicted]), axis=1))

    @property
    def settled(self) -> BoolArray:
        """Samples that are used and before which an initial-state error has decayed, shape (n,)."""
        settled = self.counted
        settled[: min(self.gain.settling, len(settled) // 4)] = False
        return settled

    @property
    def n_values(self) -> int:
        """Number of independent prediction errors that are used, and as many more as the torques count for."""
        further = 0.0 if self.torques is None else self.settings.torque_start.weight
        return round((1.0 + further) * self._predicted)

    @property
    def _predicted(self) -> int:
        """Number of independent prediction errors that are used."""
        of_tool = 0 if self.tool is None else self.tool.position.size - self.tool.basis.shape[1]
        projected = 0 if self.initial_state_errors is None else self.initial_state_errors.number
        of_sensors = 0 if self.sensors is None else self.sensors.n_values
        return int(self.values_of_motors.sum()) + of_tool + of_sensors - projected

    @property
    def values_of_motors(self) -> IntArray:
        """Number of prediction errors of each motor that are used, less those that a line determines, shape (M,)."""
        n = self.record.n_samples
        of_line = 0 if self.line is None else self.line.number(n, self.record.sample_time)
        return np.asarray(np.isfinite(self.spread).sum(axis=0) - of_line)

    @cached_property
    def noise_level(self) -> float:
        """Mean squared weighted error that noise alone leaves [1]: what a tolerance of torques adds is above it.

        Errors of the torques have no noise of the encoders. Tool and further sensors are noise, and count as such.
        """
        scale = self.measurement.driving / self.gain.noise
        tolerated = np.maximum(self.gain.spread**2 - self.gain.spread_of_noise**2, 0.0) * scale**2
        used = np.isfinite(self.spread)
        of_tolerance = np.sum(np.minimum(np.where(used, tolerated / self.spread**2, 0.0), 1.0))
        return float((self._predicted - of_tolerance) / self.n_values)

    @property
    def floor_error(self) -> float:
        """Relative standard deviation of the variance of the noise, that of further sensors included [1]."""
        of_sensors = 0.0 if self.sensors is None else self.sensors.floor_error
        return float(np.hypot(self.measurement.floor_error, of_sensors))

    @property
    def used(self) -> BoolArray:
        """Which of the weighted prediction errors are used, in their order, shape (n_residuals,)."""
        of_tool = np.ones(0 if self.tool is None else self.tool.position.size, dtype=bool)
        of_sensors = np.zeros(0, dtype=bool) if self.sensors is None else self.sensors.used
        of_torques = np.ones(0 if self.torques is None else self.torques.size, dtype=bool)
        return np.concatenate([np.isfinite(self.spread).T.ravel(), of_tool, of_sensors, of_torques])

    def squares_in_time(self, residual: FloatArray, parts: int) -> FloatArray:
        """Return the sum of squares of the errors of motors and of torques in each part of the log.

        Args:
            residual: Weighted errors in the order of `residuals`, shape (n_residuals,).
            parts: Number of parts of equal length.

        Returns:
            Sums of squares [1], shape (parts,).
        """
        n, M = self.record.position.shape
        of_torques = 0 if self.torques is None else self.torques.size
        square = residual**2
        groups = (square[: M * n].reshape(M, n), square[len(square) - of_torques :].reshape(M, -1))
        sums = np.array([[part.sum() for part in np.array_split(one, parts, axis=1)] for one in groups])
        return np.asarray(sums.sum(axis=0))

    @property
    def torque_weight(self) -> float:
        """Weight of an error of the torques: all of them count as much as the prediction errors do [1].

        What a regression leaves of a torque is its standard deviation, so that the errors at the best explanation have
        the size 1 where prediction errors have the misfit.
        """
        assert self.torques is not None
        share = self.settings.torque_start.weight * self._predicted / self.torques.n_values
        return float(np.sqrt(self.misfit * share))

    @property
    def negligible(self) -> float:
        """Fall of the sum of squares that is none where torques are known with a tolerance [1]; zero where exactly."""
        return self.settings.fit.enough_level * self.n_values if self.measurement.signal_tolerance else 0.0

    def predict(
        self,
        predictor: Predictor,
        thetas: FloatArray,
        *,
        pose_samples: IntArray | None = None,
        record_states: bool = False,
    ) -> LoopPrediction:
        """Predict the log.

        Args:
            predictor: The hypothesis.
            thetas: Parameters, shape (n_fitted, sets) with at most `LANES` sets.
            pose_samples: Samples whose tool pose is recorded, increasing, shape (m,); None for none.
            record_states: Whether to record the states.
        """
        start = predictor.behind_encoders(self.initial_state, thetas)
        if self.lead_in is not None:
            before, gain = self.lead_in
            start = predictor.predict(thetas, before, gain, start).final[: len(start)]
        return predictor.predict(
            thetas,
            self.record,
            self.gain,
            start,
            from_rest=self.from_rest,
            pose_samples=pose_samples,
            record_states=record_states,
        )

    def residuals(self, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        """Compute the weighted prediction errors of a hypothesis.

        Args:
            predictor: The hypothesis.
            thetas: Parameters, shape (n_fitted, sets) with at most `LANES` sets.

        Returns:
            Weighted prediction errors, each of variance 1 without a gap: motors one after the other, then the tool,
            then further sensors one after the other, and last the errors of the torques, motors one after the other,
            shape (M n + 3 m_tool + m_sensors + M m_torque, sets).
        """
        samples = None if self.tool is None else self.tool.samples
        prediction = self.predict(predictor, thetas, pose_samples=samples, record_states=self.sensors is not None)
        sets = thetas.shape[1]
        residual = self.weighted(prediction.innovation[:, :, :sets])
        if self.tool is not None:
            assert prediction.tool_pose is not None
            residual = np.vstack([residual, self.tool.residuals(prediction.tool_pose[:, :, :sets])])
        if self.sensors is not None:
            assert prediction.states is not None
            errors = self.sensors.errors(predictor, thetas, self.record, prediction.states)
            residual = np.vstack([residual, self.sensors.weighted(errors)])
        if self.initial_state_errors is not None:
            residual = self.initial_state_errors.projected_out(residual, self.record.n_samples)
        if self.line is not None:
            n, M = self.record.position.shape
            motors = residual[: M * n].reshape(M, n, -1)
            self.line.projected_out(motors, self.record.sample_time, np.isfinite(self.spread).T)
        if self.torques is not None:
            residual = np.vstack([residual, self.torque_weight * self.torques.errors(predictor, thetas)])
        return residual

    def weighted(self, innovation: FloatArray) -> FloatArray:
        """Weigh prediction errors.

        Args:
            innovation: Prediction errors [rad or m], shape (n, M, sets).

        Returns:
            Weighted prediction errors, shape (n M, sets); zero where they are not used.
        """
        n, M, sets = innovation.shape
        result = np.empty((M, n, sets))
        for motor in range(M):
            white = innovation[:, motor]
            if self.measurement.whitening.shape[1] > 1:
                white = lfilter(self.measurement.whitening[motor], [1.0], white, axis=0)
            np.multiply(white, self._weight[:, motor, None], out=result[motor])
        return result.reshape(M * n, sets)

    def with_tool_frame_of(self, predictor: Predictor, theta: FloatArray) -> FitData:
        """Transform the tool measurement to the frame of another prediction than that of the nominal model.

        Frame and offset of a tracker are exact only for the prediction that they were estimated with: where tolerated
        parameters turn the tool by 2e-4 rad more, an offset of 15 mm leaves 3 um, as a kinematic error would.

        Args:
            predictor: Predictor of the model.
            theta: Its parameters, shape (n_fitted,).
        """
        if self.tool is None:
            return self
        return _with_initial_state_errors(_with_tool(self, predictor, theta), predictor, theta)

    @cached_property
    def _weight(self) -> FloatArray:
        return 1.0 / self.spread


def fit_data(
    record: Record,
    model: RobotWithEffects,
    settings: DiagnosisSettings,
    measurement: Measurement | None = None,
    level: float | None = None,
    around: tuple[Predictor, FloatArray] | None = None,
) -> FitData:
    """Prepare a log for a fit: compute observer gain, initial state and weights.

    The predictor trusts the torques as `settings.level` says. Where the nominal model is so far off that predictions
    stray from the log, no candidate can be judged around them: then it follows the encoders more closely. So it does
    where its gain would settle too late in a simulated log: the gain is that of one pose, and an error that lasts for
    half a minute meets others. A rigid arm of six axes, sampled every 4 ms for 16 s, looked coloured without any gap.

    A log that begins at rest is used from its first sample, with initial-state errors projected out. One that begins
    in motion loses its first part, in which a predictor of high gain estimates the state, and is used once an error of
    that estimate has decayed.

    Args:
        record: The log.
        model: The nominal model.
        settings: Settings of the diagnosis.
        measurement: Noise of the encoders from another log of the same robot; None to measure it in this one.
        level: Torque noise that the predictor allows for, as for another log of the same robot [1]; None to choose it.
        around: Predictor and parameters of an explanation, around which the log is weighed in place of the nominal
            model: how far that one is off does not matter then.

    Raises:
        InputError: The prediction diverges.
    """
    measurement = measurement_of(record, model.robot, settings) if measurement is None else measurement
    nominal = ObservedModel.of(record, model, measurement, settings.residuals)
    beginning = nominal.beginning()
    around = (nominal.predictor, NOTHING[:, 0]) if around is None else around
    if level is None and record.premises.floor_is_noise:
        data, predicted = _followed(nominal, beginning, settings, around)
    else:  # a measured log is tied as its tolerance says
        data, predicted = _weighed(nominal, beginning, settings, settings.level if level is None else level, around)
    _check_bounded(predicted, beginning.record)
    data = _with_tool(data, *around)
    if record.sensors:
        data = _with_sensors(data, nominal.predictor, data.predict(nominal.predictor, NOTHING, record_states=True))
    return _with_initial_state_errors(data, *around)


def _followed(
    nominal: ObservedModel,
    beginning: Beginning,
    settings: DiagnosisSettings,
    around: tuple[Predictor, FloatArray],
) -> tuple[FitData, LoopPrediction]:
    """Weigh a log with an observer that settles early and follows it more closely while the model is far off."""
    numbers = settings.residuals
    level = nominal.settled_level(settings.level, beginning.record.n_samples)
    data, predicted = _weighed(nominal, beginning, settings, level, around)
    while not data.nominal_level <= numbers.far_off and 10 * data.level <= numbers.starting_level:
        data, predicted = _weighed(nominal, beginning, settings, 10 * data.level, around)
    return replace(data, least_level=level), predicted


def _weighed(
    nominal: ObservedModel,
    beginning: Beginning,
    settings: DiagnosisSettings,
    level: float,
    around: tuple[Predictor, FloatArray],
) -> tuple[FitData, LoopPrediction]:
    """Weigh the motors of a log, and predict it.

    Args:
        nominal: The nominal model.
        beginning: How the log begins.
        settings: Settings of the diagnosis.
        level: Torque noise that the observer allows for, relative [1].
        around: Predictor and parameters of what predicts the log.
    """
    record, gain, measurement = beginning.record, nominal.gain(level), nominal.measurement
    lost = lost_commands(record, nominal.predictor, gain, beginning.state, nominal.pose, settings.residuals)
    known = spread_of(lost.record, gain, measurement, from_rest=beginning.from_rest)
    spread = lost.spread(known)
    check_enough_left(lost.record, known, spread, settings.residuals)
    spread[:, ~record.predicted] = np.inf
    data = FitData(
        record=_with_usable_tool(lost.record),
        gain=gain,
        initial_state=beginning.initial_state,
        spread=spread,
        measurement=measurement,
        settings=settings,
        level=level,
        from_rest=beginning.from_rest,
        lead_in=beginning.lead_in,
        pose=nominal.pose,
    )
    predictor, theta = around
    predicted = data.predict(predictor, theta[:, None])
    errors = data.weighted(predicted.innovation[:, :, :1])
    return replace(data, nominal_level=float(np.sum(errors**2) / np.isfinite(spread).sum())), predicted


def _with_tool(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Transform the tool measurement to the frame of a prediction."""
    record, most = data.record, data.settings.residuals.tool_poses
    if record.tool is None:
        return data
    noise = tracker_noise(record.tool, predictor.robot.tool_noise)
    poses = data.predict(predictor, theta[:, None], pose_samples=np.arange(record.n_samples)).tool_pose
    assert poses is not None
    return replace(data, tool=tool_data(record.tool, poses[:, :, 0], data.counted, record.sample_time, noise, most))


def _with_sensors(data: FitData, nominal: Predictor, predicted: LoopPrediction) -> FitData:
    """Add the further sensors of a log, with warnings of those that are left out."""
    record = data.record
    if not record.sensors:
        return data
    assert predicted.states is not None
    most = data.settings.residuals.sensor_values
    sensors = sensor_data(record, data.gain, data.measurement, data.counted, nominal, predicted.states, most)
    record = replace(record, warnings=(*record.warnings, *sensors.warnings))
    return replace(data, record=record, sensors=sensors if sensors.channels else None)


def _with_initial_state_errors(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Add the effect of initial-state errors, for a log that begins at rest."""
    if not data.from_rest:
        return data
    return replace(data, initial_state_errors=initial_state_errors(data, predictor, theta))


def _with_usable_tool(record: Record) -> Record:
    """Leave out a tool measurement of too few poses, with a warning."""
    if record.tool is None:
        return record
    poses = len(usable_poses(record.tool, record.duration)[1])
    if poses >= FEWEST:
        return record
    warning = f"{poses} poses of the tool are within the log, at least {FEWEST} are needed: the tool is left out"
    return replace(record, tool=None, warnings=(*record.warnings, warning))


def _check_bounded(predicted: LoopPrediction, record: Record) -> None:
    """Refuse a log that the nominal model cannot follow at all, such as that of an unstable loop."""
    farthest = float(np.ptp(record.position, axis=0).max())
    if not np.all(np.abs(predicted.innovation[:, :, 0]) <= RUN_AWAY * farthest):
        raise InputError(
            f"{record.name}: the prediction of the nominal model diverges from this log, in which motors move by up to "
            f"{farthest:.3g} rad or m; check units, signs and order of the motors, and whether the control loop was "
            "stable, or give the log of another run"
        )
