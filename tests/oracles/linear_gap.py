"""Logs of a linearised robot with an effect, and errors of a nominal predictor: slow, independent of the compiler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from flexros.arrays import FloatArray
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.prediction.observer import ObserverGain, observer_gain
from flexros.record.record import Record
from flexros.robot import Robot
from flexros.robot.linear.linearise import linear_model

Torque = Callable[[float, FloatArray, FloatArray, FloatArray], FloatArray]
"""Disturbance torque at the motors [Nm], from time, motor positions, their rates and the torque command."""


@dataclass(frozen=True)
class LinearLog:
    """A log and its prediction."""

    robot: Robot
    record: Record
    prediction: PredictedLog
    observer: ObserverGain
    disturbance: FloatArray

    @property
    def error_spectrum(self) -> FloatArray:
        """Spectrum of the prediction errors that are due to encoder noise alone, of mean one, shape (512, M)."""
        F, C = self.observer.motion, self.observer.readout
        K = F @ self.observer.gain
        angles = np.pi * (np.arange(512) + 0.5) / 512
        H = [np.eye(len(C)) - C @ np.linalg.solve(np.exp(1j * a) * np.eye(len(F)) - F + K @ C, K) for a in angles]
        power = np.abs(np.array(H)) ** 2 @ np.asarray(self.observer.noise) ** 2
        return np.asarray(power / power.mean(axis=0))


def nothing(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
    """Return no disturbance torque."""
    del time, speed, command
    return np.zeros_like(position)


def linear_log(
    robot: Robot,
    reference: FloatArray,
    gains: tuple[float, float],
    disturbance: Torque = nothing,
    *,
    gear: Callable[[float], float] | None = None,
    seed: int = 1,
    level: float = 2e-3,
) -> LinearLog:
    """Simulate a linearised robot with a disturbance torque, and predict its motion without it.

    Args:
        robot: The robot; it is linearised at home, where its motors are at zero.
        reference: Desired motor positions [rad], shape (n, M).
        gains: Gains of position [Nm/rad] and rate [Nm s/rad].
        disturbance: Torque that the predictor does not know.
        gear: Torque of the first gear in excess of its spring, from its torsion, for robots of one motor.
        seed: Seed of the encoder noise.
        level: Level of the torque noise that the predictor assumes.
    """
    T, m = robot.sample_time, robot.n_motors
    model = linear_model(robot)
    A, B, _, _ = model.matrices()
    n_x, n = len(A), len(A) // 2
    arm, motor = robot.gear_rows[0], robot.motor_rows[0]
    between = (np.eye(n)[arm] - np.eye(n)[motor])[:, None]
    B = np.hstack([B, np.vstack([np.zeros((n, 1)), np.linalg.solve(model.mass, between)])])
    both = expm(np.block([[A, B], [np.zeros((m + 1, n_x + m + 1))]]) * T)
    F, G, inside = both[:n_x, :n_x], both[:n_x, n_x:-1], both[:n_x, -1]
    observer = observer_gain(robot, T, level, robot.encoder_noise)
    rows = np.array(robot.motor_rows)
    noise = np.random.default_rng(seed).standard_normal(reference.shape) * robot.encoder_noise
    x, guess = np.zeros(n_x), np.zeros(n_x)
    position, torque, errors, disturbances = (np.zeros_like(reference) for _ in range(4))
    states = np.zeros((len(reference), n_x))
    for k, wanted in enumerate(reference):
        q, v = x[rows], x[n_x // 2 + rows]
        position[k] = q + noise[k]
        errors[k] = position[k] - guess[rows]
        guess = guess + observer.gain @ errors[k]
        states[k] = guess
        torque[k] = gains[0] * (wanted - q) - gains[1] * v
        disturbances[k] = disturbance(k * T, q, v, torque[k])
        extra = 0.0 if gear is None else gear(float(x[motor] - x[arm]))
        x = F @ x + G @ (torque[k] + disturbances[k]) + inside * extra
        guess = F @ guess + G @ torque[k]
    record = Record("test", T, position, torque, np.ones(len(reference), dtype=bool))
    return LinearLog(robot, record, PredictedLog(errors, observer.spread, states), observer, disturbances)
