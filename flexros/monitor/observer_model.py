"""The observer model: the nominal model, driven by the torques of the robot and corrected by its encoders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.loop.prediction import PredictionLoop
from flexros.prediction.integration_step import integration_steps
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.sample_stream import Window

LOOK = 0.02
"""Initial time from which the speed of the motors is estimated [s] (chosen)."""
MOVING = 5.0
"""Speed over its standard deviation above which the robot starts in motion [1] (chosen)."""
RUN_AWAY = 1e3
"""Prediction error beyond which the observer has diverged [rad or m] (chosen)."""


class ObserverModel:
    """Observer model of a running robot.

    Args:
        model: The nominal model, robot and laws of effects.
        sample_time: Time between two samples [s].

    Attributes:
        robot: The robot of the model.
        starts_in_motion: Whether the robot moved at the initial state.
    """

    def __init__(self, model: RobotWithEffects, sample_time: float) -> None:
        self.robot, self._sample_time = model.robot, sample_time
        felt = [law for law in model.laws if not law.effect.as_noise]
        self._plant = PlantModel(model.robot, felt)
        steps = integration_steps(
            model.robot,
            sample_time,
            may_be_implicit=model.robot.is_rigid,
            fast=any(law.effect.needs_short_steps for law in felt),
            curved=self._plant.friction_follows_speed,
        )
        self._loop = PredictionLoop(
            self._plant.functions(
                feed_through(model.robot.n_motors), implicit=steps.implicit, placed=model.robot.is_rigid
            ),
            sample_time=sample_time,
            delay=self._plant.delay,
            substeps=steps.number,
        )
        self._none = np.zeros((0, 1))
        self.starts_in_motion = False

    def begin(self, window: Window) -> None:
        """Set the initial state: at rest, or moving as a stiff robot.

        Args:
            window: First window.
        """
        count = min(max(round(LOOK / self._sample_time), 4), len(window.position))
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
            window: The window, which follows the one before.
            gain: Gain of the observer, shape (2 n, M).

        Returns:
            Prediction errors [rad or m], zero where nothing was measured, shape (samples, M); None where the observer
            has diverged.
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
        """Correct the state.

        Args:
            shift: Correction of positions and speeds of the robot, shape (2 n,).
        """
        self._state = self._state + self._plant.corrections(shift[:, None])
