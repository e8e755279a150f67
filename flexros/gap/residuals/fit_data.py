"""A log as a fit sees it: with gain, start, and weights of its prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

from flexros.errors import InputError
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.noise.weights import measurement_of, spread_of
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.initial_state import StartErrors, start_errors
from flexros.gap.residuals.lost_commands import spoilt_by_lost_commands
from flexros.gap.residuals.tool_data import tool_data, tracker_noise
from flexros.gap.residuals.tool_frame import FEWEST, usable_poses
from flexros.prediction.observer import observer_gain

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.compile.loop.prediction import LoopPrediction
    from flexros.effects import RobotWithEffects
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.residuals.tool_data import ToolData
    from flexros.gap.settings import DiagnosisSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record

STARTING_LEVEL = 0.3
"""Torque noise that the predictor allows for while it finds the state of a log that begins in motion [1] (chosen)."""
RUN_AWAY = 1e6
"""Largest prediction error over the largest motion of the log; beyond it the prediction has run away [1] (chosen)."""
REST, AT_REST = 0.02, 10.0
"""Time at the begin of a log that tells whether the robot starts from rest [s], and prediction errors from rest, over
the noise, up to which it does [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class FitData:
    """Log and what the fit needs to weigh its prediction errors.

    Attributes:
        record: The log.
        gain: Gain of the predictor.
        start: State of the robot before the first sample, shape (2 n_coordinates,).
        spread: Standard deviation of a prediction error without gap [rad or m], shape (n, M); infinite where a sample
            was not measured, or the start of a log that begins in motion or a lost command has not decayed.
        measurement: Noise of the encoders.
        from_rest: Whether the log begins at rest, where every model starts from its own rest.
        pose: Arm coordinates at which the gain was computed [rad or m], shape (N,); None for home.
        tool: What a tool tracker saw; None where there was none.
        start_errors: What errors of the start do, which is taken off; None where the start does not count.
    """

    record: Record
    gain: ObserverGain
    start: FloatArray
    spread: FloatArray
    measurement: Measurement
    from_rest: bool = False
    tool: ToolData | None = None
    pose: FloatArray | None = None
    start_errors: StartErrors | None = None

    @property
    def counted(self) -> BoolArray:
        """Samples whose prediction errors count, shape (n,)."""
        return np.asarray(self.record.valid & np.all(np.isfinite(self.spread), axis=1))

    @property
    def settled(self) -> BoolArray:
        """Samples that count and before which an error of the start has decayed, shape (n,)."""
        settled = self.counted
        settled[: min(self.gain.settling, len(settled) // 4)] = False
        return settled

    @property
    def n_values(self) -> int:
        """Number of prediction errors that count."""
        of_tool = 0 if self.tool is None else self.tool.position.size - self.tool.basis.shape[1]
        of_start = 0 if self.start_errors is None else self.start_errors.number
        return int(np.isfinite(self.spread).sum()) + of_tool - of_start

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
            thetas: Numbers, shape (n_fitted, sets) with at most `LANES` sets.
            pose_samples: Samples whose tool pose is recorded, increasing, shape (m,); None for none.
            record_states: Whether to record the states.
        """
        return predictor.predict(
            thetas,
            self.record,
            self.gain,
            self.start,
            from_rest=self.from_rest,
            pose_samples=pose_samples,
            record_states=record_states,
        )

    def residuals(self, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        """Predict and weigh.

        Args:
            predictor: The hypothesis.
            thetas: Numbers, shape (n_fitted, sets) with at most `LANES` sets.

        Returns:
            Weighted prediction errors, each of variance 1 without gap: those of the motors one after the other, then
            those of the tool, shape (M n + 3 m, sets).
        """
        samples = None if self.tool is None else self.tool.samples
        prediction = self.predict(predictor, thetas, pose_samples=samples)
        sets = thetas.shape[1]
        residual = self.weighted(prediction.innovation[:, :, :sets])
        if self.tool is not None:
            assert prediction.tool_pose is not None
            residual = np.vstack([residual, self.tool.residuals(prediction.tool_pose[:, :, :sets])])
        if self.start_errors is not None:
            residual = self.start_errors.taken_off(residual, self.record.n_samples)
        return residual

    def weighted(self, innovation: FloatArray) -> FloatArray:
        """Weigh prediction errors.

        Args:
            innovation: Prediction errors [rad or m], shape (n, M, sets).

        Returns:
            Weighted prediction errors, shape (n M, sets); zero where they do not count.
        """
        n, M, sets = innovation.shape
        result = np.empty((M, n, sets))
        for motor in range(M):
            white = innovation[:, motor]
            if self.measurement.whitening.shape[1] > 1:
                white = lfilter(self.measurement.whitening[motor], [1.0], white, axis=0)
            np.multiply(white, self._weight[:, motor, None], out=result[motor])
        return result.reshape(M * n, sets)

    def tool_seen_by(self, predictor: Predictor, theta: FloatArray) -> FitData:
        """Bring what a tool tracker saw to the frame of another prediction than that of the nominal model.

        Frame and offset of a tracker are exact for the prediction that they were estimated with: where tolerated
        numbers turn the tool by 2e-4 rad more, an offset of 15 mm leaves 3 um, as an error of the kinematics would.

        Args:
            predictor: Predictor of the model.
            theta: Its numbers, shape (n_fitted,).
        """
        if self.tool is None:
            return self
        samples = np.arange(self.record.n_samples)
        predicted = self.predict(predictor, theta[:, None], pose_samples=samples)
        return _with_start_errors(_with_tool(self, predicted, predictor.robot.tool_noise), predictor, theta)

    @cached_property
    def _weight(self) -> FloatArray:
        return 1.0 / self.spread


def fit_data(
    record: Record,
    model: RobotWithEffects,
    settings: DiagnosisSettings,
    measurement: Measurement | None = None,
) -> FitData:
    """Give a log gain, start and weights.

    A log that begins at rest counts from its first sample, less what errors of the start explain. One that begins in
    motion loses its first part, in which a predictor of high gain finds the state, and does not count until an error of
    that has decayed.

    Args:
        record: The log.
        model: The nominal model.
        settings: Numbers of the diagnosis.
        measurement: Noise of the encoders as another log of the same robot shows it; None to measure it in this one.

    Raises:
        InputError: The prediction of the nominal model runs away.
    """
    robot = model.robot
    pose = robot.equilibrium(motor_position=np.median(record.position, axis=0))[: robot.n_arm]
    measurement = measurement_of(record, robot) if measurement is None else measurement

    tolerated = measurement.signal_tolerance * np.std(record.torque, axis=0) if measurement.signal_tolerance else None

    def gain_at(level: float) -> ObserverGain:
        return observer_gain(robot, record.sample_time, level, measurement.deviation, pose, tolerated=tolerated)

    nominal = Predictor(model, (), Tolerance(), record.sample_time, measured_torque=record.measured_torque)
    start = robot.equilibrium(motor_position=record.position[0])
    fast = gain_at(STARTING_LEVEL)
    soon = record.part(0, max(round(REST / record.sample_time), 2))
    errors = nominal.predict(np.zeros((0, 1)), soon, fast, start).innovation[:, :, 0]
    seen = np.abs(errors[soon.valid])
    from_rest = bool(len(seen) and np.all(seen < AT_REST * measurement.deviation))
    if not from_rest:
        cut = min(2 * fast.settling, record.n_samples // 4)
        found = nominal.predict(np.zeros((0, 1)), record.part(0, cut), fast, start)
        start, record = found.final[: len(start), 0], record.part(cut, record.n_samples)
    gain = gain_at(settings.level)
    spread = spread_of(record, gain, measurement, from_rest=from_rest)
    spread[spoilt_by_lost_commands(record, nominal, gain, start)] = np.inf
    data = FitData(_with_usable_tool(record), gain, start, spread, measurement, from_rest, None, pose)
    samples = None if data.record.tool is None else np.arange(record.n_samples)
    predicted = data.predict(nominal, np.zeros((0, 1)), pose_samples=samples)
    _check_bounded(predicted, record)
    return _with_start_errors(_with_tool(data, predicted, robot.tool_noise), nominal, np.zeros(0))


def _with_tool(data: FitData, predicted: LoopPrediction, declared: float) -> FitData:
    """Bring what a tool tracker saw to the frame of a prediction."""
    record = data.record
    if record.tool is None:
        return data
    assert predicted.tool_pose is not None
    noise = tracker_noise(record.tool, declared)
    tool = tool_data(record.tool, predicted.tool_pose[:, :, 0], data.counted, record.sample_time, noise)
    return replace(data, tool=tool)


def _with_start_errors(data: FitData, predictor: Predictor, theta: FloatArray) -> FitData:
    """Find what errors of a start at rest do, as a model sees them."""
    return replace(data, start_errors=start_errors(data, predictor, theta)) if data.from_rest else data


def _with_usable_tool(record: Record) -> Record:
    """Leave out a tool measurement of too few poses, with a warning."""
    if record.tool is None:
        return record
    poses = len(usable_poses(record.tool, record.duration)[1])
    if poses >= FEWEST:
        return record
    warning = f"{poses} poses of the tool lie within the record, needed are {FEWEST}, so the tool was left out"
    return replace(record, tool=None, warnings=(*record.warnings, warning))


def _check_bounded(predicted: LoopPrediction, record: Record) -> None:
    """Refuse a log that the nominal model cannot follow at all, as that of a loop which was not stable."""
    farthest = float(np.ptp(record.position, axis=0).max())
    if not np.all(np.abs(predicted.innovation[:, :, 0]) <= RUN_AWAY * farthest):
        raise InputError(
            f"{record.name}: the prediction of the nominal model runs away from this log, in which motors move by up "
            f"to {farthest:.3g} rad or m; check units, signs and order of the motors, and whether the control loop was "
            "stable, or give the log of another run"
        )
