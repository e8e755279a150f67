"""Torque that the servos of a robot file make from commanded and measured positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.smoothing import smooth_motion
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

FASTEST = 50.0
"""Corner frequency of the low-pass for the measured motion [Hz] (chosen)."""


@dataclass(frozen=True, eq=False)
class ServoParts:
    """Torques of servos without limits.

    Attributes:
        spring: Stiffness times distance [Nm or N], shape (n, M).
        damper: Damping times speed and its feedforward [Nm or N], shape (n, M).
        integral: Integral parts, from those of the robot at rest at the first position [Nm or N], shape (n, M).
    """

    spring: FloatArray
    damper: FloatArray
    integral: FloatArray

    @property
    def torque(self) -> FloatArray:
        """Sum of all parts [Nm or N], shape (n, M)."""
        return self.spring + self.damper + self.integral


def servo_torque(robot: Robot, command: FloatArray, position: FloatArray, sample_time: float) -> FloatArray:
    """Return the torques of the nominal servos, from smoothed measured positions.

    They serve scales, regimes and pictures; a prediction closes the servos around the predicted motion instead.

    Args:
        robot: The nominal robot, with servos.
        command: Commanded positions, held from sample to sample [rad or m], shape (n, M).
        position: Measured positions [rad or m], shape (n, M).
        sample_time: Time between two samples [s].

    Returns:
        Torques, each within the torque limit [Nm or N], shape (n, M).
    """
    parts = servo_parts(robot, command, position, sample_time)
    return np.asarray(np.clip(parts.torque, -robot.torque_limits, robot.torque_limits))


def servo_parts(robot: Robot, command: FloatArray, position: FloatArray, sample_time: float) -> ServoParts:
    """Return the parts of the torques of the nominal servos, from smoothed measured positions.

    Args:
        robot: The nominal robot, with servos.
        command: Commanded positions [rad or m], shape (n, M).
        position: Measured positions [rad or m], shape (n, M).
        sample_time: Time between two samples [s].
    """
    stiffness, damping, feedforward, integral = (
        np.array([robot.parameters[f"{motor}.{SERVO}{name}"].value for motor in robot.joint_names])
        for name in ("stiffness", "damping", "feedforward", "integral")
    )
    few = len(position) < 32  # too short for the low-pass
    motion = np.stack([position, np.gradient(position, sample_time, axis=0)]) if few else None
    if motion is None:
        motion = smooth_motion(position, sample_time, min(FASTEST, 0.1 / sample_time))
    rate = np.gradient(command, sample_time, axis=0)
    spring, damper = stiffness * (command - motion[0]), damping * (feedforward * rate - motion[1])
    summed = np.zeros_like(spring)
    if integral.any():
        summed[1:] = integral * sample_time * np.cumsum(command - motion[0], axis=0)[:-1]
        held = robot.holding_torque(robot.equilibrium(motor_position=position[0]))
        summed += np.where(integral > 0, held - spring[0] - damper[0], 0.0)
    return ServoParts(spring, damper, summed)
