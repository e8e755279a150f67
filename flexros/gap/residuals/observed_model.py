"""The nominal model tied to a log by an observer: its gain, and how the log begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.feedforward.compensation.encoder_reading import position_of_reading
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.noise.weights import noise_of_positions
from flexros.gap.prediction.predictor import Predictor
from flexros.prediction.observer import observer_gain

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.noise.weights import Measurement
    from flexros.gap.settings import ResidualSettings
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record
    from flexros.robot import Robot

REST = 0.02
"""Time at the beginning of a log in which prediction errors from rest decide whether it begins at rest [s] (chosen)."""
FEWEST = 5
"""Fewest samples that tell a speed beside an acceleration [1] (chosen)."""
NOTHING = np.zeros((0, 1))
"""Parameters of the nominal model: none."""


@dataclass(frozen=True, eq=False)
class Beginning:
    """How a log begins.

    Attributes:
        record: The log from its first sample after the lead-in.
        initial_state: State of the robot before the first sample, shape (2 n_coordinates,); of the lead-in where there
            is one.
        state: The same of `record`.
        lead_in: First part of a log that begins in motion, with the gain of the observer that finds the state there;
            None for one that begins at rest.
    """

    record: Record
    initial_state: FloatArray
    state: FloatArray
    lead_in: tuple[Record, ObserverGain] | None = None

    @property
    def from_rest(self) -> bool:
        """Whether it begins at rest, in which case every model begins in its own equilibrium."""
        return self.lead_in is None


@dataclass(frozen=True, eq=False)
class ObservedModel:
    """The nominal model, corrected by the measured positions of a log.

    Attributes:
        robot: The nominal robot.
        predictor: Predictor of the nominal model.
        record: The log.
        measurement: Noise of the encoders.
        noise: Usual noise of the positions [rad or m], shape (M,).
        tolerated: Torques that count as no gap [Nm or N], shape (M,); None where torques are known exactly.
        pose: Arm coordinates at which gains are computed [rad or m], shape (N,).
        settings: Settings of the residuals.
    """

    robot: Robot
    predictor: Predictor
    record: Record
    measurement: Measurement
    noise: FloatArray
    tolerated: FloatArray | None
    pose: FloatArray
    settings: ResidualSettings

    @classmethod
    def of(
        cls, record: Record, model: RobotWithEffects, measurement: Measurement, settings: ResidualSettings
    ) -> ObservedModel:
        """Tie a model to a log.

        Args:
            record: The log.
            model: The nominal model.
            measurement: Noise of the encoders.
            settings: Settings of the residuals.
        """
        robot = model.robot
        return cls(
            robot=robot,
            predictor=Predictor(model, (), Tolerance(), record.sample_time, measured_torque=record.measured_torque),
            record=record,
            measurement=measurement,
            noise=noise_of_positions(record, measurement),
            tolerated=measurement.uncertain_torque(record),
            pose=robot.equilibrium(motor_position=np.median(record.position, axis=0))[: robot.n_arm],
            settings=settings,
        )

    def gain(self, level: float) -> ObserverGain:
        """Return the gain that allows for a relative torque noise, see `observer_gain` [1]."""
        return observer_gain(
            self.robot, self.record.sample_time, level, self.noise, self.pose, tolerated=self.tolerated
        )

    def settled_level(self, level: float, n_samples: int) -> float:
        """Return the least torque noise, in steps of two, whose gain settles early in a log [1].

        Args:
            level: The torque noise to begin with [1].
            n_samples: Samples of the log.
        """
        numbers = self.settings
        while 2 * level <= numbers.starting_level and self.gain(level).settling > numbers.settles_within * n_samples:
            level *= 2
        return level

    def beginning(self) -> Beginning:
        """Find whether the log begins at rest; the first part of one that does not is for finding the state."""
        record, fast = self.record, self.gain(self.settings.starting_level)
        first = position_of_reading(self.robot, self.predictor.plant.model.laws, record.position[0])
        state = self.robot.equilibrium(motor_position=first)
        if self._begins_at_rest(state, fast):
            return Beginning(record, state, state)
        cut = min(2 * fast.settling, record.n_samples // 4)
        lead_in = record.part(0, cut), fast
        found = self.predictor.predict(NOTHING, *lead_in, state).final[: len(state), 0]
        return Beginning(record.part(cut, record.n_samples), state, found, lead_in)

    def _begins_at_rest(self, state: FloatArray, gain: ObserverGain) -> bool:
        """Return whether predictions from an equilibrium meet the first samples.

        The observer follows a slow motion closely enough to meet it from rest, so that a part that was cut out of a log
        must begin without a speed, too. A whole log begins where its motion does, with a jerk that is none.
        """
        soon = self.record.part(0, max(round(REST / self.record.sample_time), 2))
        errors = self.predictor.predict(NOTHING, soon, gain, state).innovation[:, :, 0]
        seen, most = np.abs(errors[soon.valid]), self.settings.at_rest
        if not len(seen) or not np.all(seen < most * self.measurement.deviation):
            return False
        return not self.record.begin or bool(np.all(self._first_speed(soon) < most))

    def _first_speed(self, soon: Record) -> FloatArray:
        """Return the speeds at the first sample over their standard deviations by noise [1], shape (M,).

        A parabola through the first samples leaves out the acceleration of a motion that begins. Of a few samples,
        which tell none, the speeds are zero.

        Args:
            soon: The first samples.
        """
        time, valid = np.arange(soon.n_samples) / soon.n_samples, soon.valid
        if np.count_nonzero(valid) < FEWEST:
            return np.zeros(soon.position.shape[1])
        powers = np.vander(time[valid], 3, increasing=True)
        inverse = np.linalg.pinv(powers)[1]
        return np.asarray(
            np.abs(inverse @ soon.position[valid]) / (np.linalg.norm(inverse) * self.measurement.deviation)
        )
