"""Efforts of a log against the torques that the model needs for its motion, with joints turned or moved on trial."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import butter, sosfiltfilt

from flexros.errors import InputError
from flexros.record.balance.inverse_dynamics import SlowMotion
from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

SLOW = 5.0
"""Frequency below which they are compared [Hz] (chosen): weight and motion of an arm are below."""
CREEP = 0.02
"""Speed at which dry friction has its full size, over the rms of the speed [1] (chosen)."""
LEAST_REST = 1e-6
"""Power of the torque of the model that friction, rotor and constant must leave of it [1] (chosen)."""


@dataclass(frozen=True)
class Comparison:
    """The effort of a motor against the torque of the model, both without friction, rotor and constant.

    Attributes:
        factor: Effort over torque of the model.
        correlation: Their partial correlation [1].
        power: Power of that torque.
        unexplained: Power of the effort that is left, over that of the effort without its mean, 0 ... 1.
    """

    factor: float
    correlation: float
    power: float
    unexplained: float


@dataclass(frozen=True, eq=False)
class EffortComparison:
    """Slow motion and efforts of a log.

    Attributes:
        robot: The model.
        motion: The motion.
        sample_time: Time between two samples [s].
        effort: Low-passed efforts, shape (n, M).
        others: Low-passed speed, sign of the speed and acceleration of each motor, and a constant, length M, each of
            shape (n, 4).
    """

    robot: Robot
    motion: SlowMotion
    sample_time: float
    effort: FloatArray
    others: tuple[FloatArray, ...]

    @classmethod
    def of(cls, record: Record, robot: Robot) -> EffortComparison:
        """Low-pass a log.

        Args:
            record: The log, its torques those of the effort.
            robot: The model.
        """
        T = record.sample_time
        position, cutoff = bridged_motion(record.position, record.valid), min(SLOW, 0.1 / T)
        _, speed, acceleration = smooth_motion(position, T, cutoff)
        creep = CREEP * np.maximum(np.std(speed, axis=0), 1e-12)
        filtered = (_low_passed(one, T) for one in (speed, np.tanh(speed / creep), acceleration))
        signals = np.stack([*filtered, np.ones_like(speed)], axis=2)
        others = tuple(signals[:, k] for k in range(robot.n_motors))
        return cls(robot, SlowMotion.of(position, T, cutoff), T, _low_passed(record.torque, T), others)

    def at(self, signs: FloatArray | float = 1.0, offset: FloatArray | float = 0.0) -> tuple[Comparison, ...]:
        """Regress the effort of every motor on the torque that the model needs; its own sign is free.

        Args:
            signs: -1 for joints that are turned, shape (M,).
            offset: What is added to the positions [rad or m], shape (M,).

        Returns:
            Comparisons, length M; without correlation where the robot has no equilibrium near the motion.
        """
        try:
            needed = replace(self.motion, motion=signs * self.motion.motion).torque(self.robot, offset)
        except InputError:
            return (Comparison(1.0, 0.0, 0.0, 1.0),) * self.robot.n_motors
        needed = _low_passed(needed, self.sample_time)
        return tuple(_partial(*one) for one in zip(needed.T, self.effort.T, self.others, strict=True))


def _low_passed(signals: FloatArray, sample_time: float) -> FloatArray:
    low_pass = butter(2, min(SLOW, 0.1 / sample_time), fs=1 / sample_time, output="sos")
    return np.asarray(sosfiltfilt(low_pass, signals, axis=0))


def _partial(needed: FloatArray, effort: FloatArray, others: FloatArray) -> Comparison:
    """Compare an effort with the needed torque, both without what other columns explain of them."""
    basis = np.linalg.qr(others / np.maximum(np.linalg.norm(others, axis=0), 1e-300))[0]
    rest, own = effort - basis @ (basis.T @ effort), needed - basis @ (basis.T @ needed)
    power, both, size = float(own @ own), float(own @ rest), float(rest @ rest)
    whole = max(float(np.sum((effort - effort.mean()) ** 2)), 1e-300)
    if not (power > LEAST_REST * float(needed @ needed) and size > 0):
        return Comparison(1.0, 0.0, 0.0, size / whole)
    return Comparison(both / power, both / float(np.sqrt(power * size)), power, (size - both**2 / power) / whole)
