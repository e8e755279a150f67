"""A log prepared for a fit: its weighted prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.compile.loop.prediction import LoopPrediction
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.initial_state_errors import InitialStateErrors
    from flexros.gap.residuals.line import Line
    from flexros.gap.residuals.sensor_data import SensorData
    from flexros.gap.residuals.tool_data import ToolData
    from flexros.gap.residuals.torque_errors import TorqueErrors
    from flexros.gap.settings import DiagnosisSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record


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
        torque_noise: Torque noise that the predictor allows for, relative: see `observer_gain` [1].
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
        least_torque_noise: Torque noise that the predictor would allow for if the model were not far off [1]; infinite
            where that does not matter, as in logs of real machines.
    """

    record: Record
    gain: ObserverGain
    initial_state: FloatArray
    spread: FloatArray
    measurement: Measurement
    settings: DiagnosisSettings
    torque_noise: float
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
    least_torque_noise: float = np.inf

    @property
    def without_torques(self) -> FitData:
        """The same log, whose torques do not count."""
        return replace(self, torques=None)

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
            with np.errstate(over="ignore"):  # a prediction that diverged
                np.multiply(white, self._weight[:, motor, None], out=result[motor])
        return result.reshape(M * n, sets)

    @cached_property
    def _weight(self) -> FloatArray:
        return 1.0 / self.spread
