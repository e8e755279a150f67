"""Inverse-dynamics torque of the nominal robot for a measured motion: linearised and elastic, or rigid in any pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.feedforward.rigid_arm import rigid_arm
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.robot import Robot
    from flexros.robot.linear.positions import LinearisedPositions

_PER_PERIOD = 8  # samples per period of the highest frequency at which the rigid arm is evaluated


@dataclass(frozen=True, eq=False)
class ElasticInverseDynamics:
    """The robot linearised at some motor positions.

    Attributes:
        linear: The linear models.
    """

    linear: LinearisedPositions

    @classmethod
    def of(cls, robot: Robot, motor_positions: FloatArray) -> ElasticInverseDynamics:
        """Linearise a robot.

        Args:
            robot: The robot.
            motor_positions: Motor positions [rad or m], shape (Q, M).

        Raises:
            InputError: The robot has no equilibrium at one of them.
        """
        from flexros.robot.linear.positions import linearise_positions  # here, because it loads slowly

        return cls(linearise_positions(robot, (), motor_positions))

    @property
    def lowest(self) -> float:
        """Lowest resonance with locked motors over the positions [Hz]; infinite without one."""
        linear = self.linear
        n = linear.mass.shape[1]
        free = np.setdiff1d(np.arange(n), linear.motor_rows)
        if not free.size:
            return float("inf")
        square = np.linalg.eigvals(
            np.linalg.solve(linear.mass[:, free][:, :, free], linear.stiffness[:, free][:, :, free])
        ).real
        return float(np.sqrt(max(square.min(), 0.0)) / (2 * np.pi))

    def at(self, w: FloatArray, motor_position: FloatArray) -> ComplexArray:
        """Evaluate the matrices from motor positions to torques at the nearest position.

        Args:
            w: Angular frequencies [rad/s], shape (F,).
            motor_position: Motor positions [rad or m], shape (M,).

        Returns:
            Matrices [Nm/rad or N/m], shape (F, M, M).
        """
        linear = self.linear
        k = int(np.argmin(np.sum((linear.motor_positions - motor_position) ** 2, axis=1)))
        s = 1j * w[:, None, None]
        Z = linear.stiffness[k] + s * linear.damping[k] + s**2 * linear.mass[k]
        motor_rows = linear.motor_rows
        free = np.setdiff1d(np.arange(Z.shape[1]), motor_rows)
        reduced = Z[:, motor_rows][:, :, motor_rows]
        if free.size:
            inner = np.linalg.solve(Z[:, free][:, :, free], Z[:, free][:, :, motor_rows])
            reduced = reduced - np.matmul(Z[:, motor_rows][:, :, free], inner)
        return np.asarray(reduced)


@dataclass(frozen=True, eq=False)
class SlowMotion:
    """A motion below a frequency, at as few samples as it needs.

    Attributes:
        samples: The samples, the first and the last one among them, shape (k,).
        motion: Motor positions, speeds and accelerations there, shape (3, k, M).
        n_samples: How many samples the motion has.
    """

    samples: IntArray
    motion: FloatArray
    n_samples: int

    @classmethod
    def of(cls, position: FloatArray, sample_time: float, highest: float) -> SlowMotion:
        """Smooth a motion.

        Args:
            position: Motor positions without holes [rad or m], shape (n, M).
            sample_time: Time between two samples [s].
            highest: Frequency up to which the torque is required [Hz].
        """
        n = len(position)
        factor = max(1, int(1 / (sample_time * _PER_PERIOD * 2.5 * highest)))
        samples = np.arange(0, n, factor)
        samples = samples if samples[-1] == n - 1 else np.append(samples, n - 1)
        cutoff = min(2.5 * highest, 0.2 / sample_time)
        motions = [smooth_motion(column[:, None], sample_time, cutoff)[:, samples] for column in position.T]
        return cls(samples, np.concatenate(motions, axis=2), n)

    def torque(self, robot: Robot, offset: FloatArray | float = 0.0) -> FloatArray:
        """Evaluate the inverse dynamics of the rigid arm at all samples [Nm or N], shape (n, M).

        Args:
            robot: The robot.
            offset: What is added to the positions [rad or m], shape (M,).
        """
        position, *derivatives = self.motion
        torque = rigid_arm(robot).inverse_dynamics(np.stack([position + offset, *derivatives])).torque
        return np.column_stack([np.interp(np.arange(self.n_samples), self.samples, column) for column in torque.T])


def rigid_inverse_dynamics(robot: Robot, position: FloatArray, sample_time: float, highest: float) -> FloatArray:
    """Evaluate the inverse dynamics of the rigid arm along a motion, below a frequency.

    Args:
        robot: The robot.
        position: Motor positions without holes [rad or m], shape (n, M).
        sample_time: Time between two samples [s].
        highest: Frequency up to which the torque is required [Hz].

    Returns:
        Torques [Nm or N], shape (n, M).
    """
    return SlowMotion.of(position, sample_time, highest).torque(robot)
