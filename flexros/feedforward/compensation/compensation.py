"""Compensation of effects in addition to the robot's model: delays, look-ahead, and the order of the laws."""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.effects.delay import Delay
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.feedforward.compensation.arm_forces import acts_at_once
from flexros.feedforward.compensation.encoder_reading import encoder_reading
from flexros.feedforward.compensation.gears import SMOOTHING_TIME, with_gear_laws
from flexros.feedforward.compensation.motors import with_motor_laws
from flexros.feedforward.hold import samples_ahead

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Motion
    from flexros.robot import Robot

RATES = 3
"""Samples beyond the present one on which second derivatives by central differences depend."""


def compensated(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> Motion:
    """Change a motion such that a robot with the effects follows the path of the one without.

    Effects that change the model are part of the robot and therefore of its motion. The laws are inverted from the arm
    to the command: gear, motor, encoder.

    Args:
        motion: The whole motion of the robot without the laws.
        robot: That robot.
        laws: Laws on it; a neutral one is skipped.
        sample_time: Distance of the samples [s].

    Returns:
        The motion with the laws, without those that `uncompensated` names.
    """
    active = [law for law in laws if not law.effect.neutral]
    motion = with_gear_laws(motion, robot, active, sample_time)
    motion = with_motor_laws(motion, robot, active, sample_time)
    return _as_encoders_read(motion, robot, active)


def motor_delays(robot: Robot, laws: Sequence[PlacedLaw]) -> tuple[float, ...]:
    """Return the time until a command acts, for each motor.

    Args:
        robot: The robot, with the delay of all motors.
        laws: Laws on it, some of which may delay single motors.

    Returns:
        Delays [s], length M.
    """
    delays = dict.fromkeys(robot.joint_names, robot.delay)
    for law in laws:
        if isinstance(law.effect, Delay):
            delays[law.location] += law.effect.time
    return tuple(delays.values())


def look_ahead(robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> int:
    """Return the number of samples beyond the present one that a reference may depend on.

    Args:
        robot: The robot, with the delay of all motors.
        laws: Laws on it that are compensated.
        sample_time: Distance of the samples [s].

    Returns:
        Samples of the hold; with laws also those of the smoothing of a jump and of derivatives.
    """
    ahead = samples_ahead(sample_time, max(motor_delays(robot, laws)))
    return ahead + ceil(SMOOTHING_TIME / sample_time) + RATES if laws else ahead


def laws_of_the_arm(laws: Sequence[PlacedLaw]) -> tuple[PlacedLaw, ...]:
    """Select the laws that are part of the arm's equations: forces on it, and errors of its kinematics."""
    return tuple(
        law
        for law in laws
        if not law.effect.neutral and (acts_at_once(law) or isinstance(law.effect, AbstractToolError))
    )


def _as_encoders_read(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw]) -> Motion:
    """Convert motor positions to the readings of encoders with periodic errors."""
    position, velocity = motion.motor_position.copy(), motion.motor_velocity.copy()
    for number in range(robot.n_motors):
        rows = [ca.DM(array[np.newaxis, :, number]) for array in (position, velocity)]
        read, rate = encoder_reading(robot, laws, number).call(rows)
        position[:, number], velocity[:, number] = np.array(read).ravel(), np.array(rate).ravel()
    return replace(motion, motor_position=position, motor_velocity=velocity)
