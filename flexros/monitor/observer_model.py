"""The nominal twin: the model of the robot with the torques of the robot, tied to its encoders, window by window."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.loop.prediction import PredictionLoop
from flexros.simulate.loop import feed_through
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.sample_stream import Window

LONGEST_STEP = 5e-4
"""Longest integration step [s]; lower rates take several steps per sample."""
LOOK = 0.02
"""Time at the start from which the speed of the motors is read [s] (chosen)."""
MOVING = 5.0
"""Speed over its standard deviation from which a start counts as in motion [1] (chosen)."""
RUN_AWAY = 1e3
"""Prediction error from which the twin has lost the robot [rad or m] (chosen)."""


class ObserverModel:
    """The model that runs beside the robot.

    Args:
        model: The nominal model, robot and laws of effects.
        sample_time: Time between two samples [s].

    Attributes:
        robot: The robot of the model.
        starts_in_motion: Whether the robot moved when the twin began.
    """

    def __init__(self, model: RobotWithEffects, sample_time: float) -> None:
        self.robot, self._sample_time = model.robot, sample_time
        felt = [law for law in model.laws if not law.effect.as_noise]
        self._plant = PlantModel(model.robot, felt)
        self._loop = PredictionLoop(
            self._plant.functions(feed_through(model.robot.n_motors)),
            sample_time=sample_time,
            delay=self._plant.delay,
            substeps=max(1, int(np.ceil(sample_time / LONGEST_STEP - 1e-9))),
        )
        self._none = np.zeros((0, 1))
        self.starts_in_motion = False

    def begin(self, window: Window) -> None:
        """Put the twin where the robot is: at rest, or as a stiff robot moves.

        Args:
            window: First window.
        """
        count = max(round(LOOK / self._sample_time), 4)
        time = (np.arange(count) - (count - 1) / 2) * self._sample_time
        position = window.position[:count]
        speed = time @ position / (time @ time)
        at = position.mean(axis=0) - speed * (count - 1) / 2 * self._sample_time
        moving = np.abs(speed) > MOVING * self.robot.encoder_noise / np.sqrt(time @ time)
        self.starts_in_motion = bool(moving.any())
        state = self.robot.equilibrium(motor_position=at)
        if self.starts_in_motion:
            n = self.robot.n_coordinates
            ahead = self.robot.equilibrium(state[: self.robot.n_arm], motor_position=at + speed * LOOK)
            state[n:] = (ahead[:n] - state[:n]) / LOOK
        torque = window.torque[0]
        self._state = self._plant.start(state, torque)[:, None]
        self._past = np.repeat(torque[None], max(self._loop.line_length, 1), axis=0)

    def run(self, window: Window, gain: FloatArray) -> FloatArray | None:
        """Predict a window.

        Args:
            window: The window, which follows on the one before.
            gain: Gain of the twin, shape (2 n, M).

        Returns:
            Prediction errors [rad or m], zero where nothing was measured, shape (samples, M); None where the twin has
            lost the robot.
        """
        length = self._loop.line_length
        found = self._loop.run(
            self._state,
            self._none,
            self._plant.corrections(gain),
            window.torque,
            window.position,
            window.measured.astype(float),
            past=self._past[:length],
        )
        self._state = found.final
        self._past = np.concatenate([window.torque[::-1], self._past])[: max(length, 1)]
        errors = found.innovation[:, :, 0]
        return errors if np.all(np.abs(errors) < RUN_AWAY) else None

    def correct(self, shift: FloatArray) -> None:
        """Move the state.

        Args:
            shift: What is added to positions and speeds of the robot, shape (2 n,).
        """
        self._state = self._state + self._plant.corrections(shift[:, None])
