"""Making up for effects that are laws beside the robot's model: what the reference changes, and what it cannot."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.effects.delay import Delay
from flexros.effects.sensor import AbstractSensor
from flexros.effects.tool_error import AbstractToolError
from flexros.feedforward.arm_forces import acts_at_once
from flexros.feedforward.gear_compensation import with_gear_laws
from flexros.feedforward.motor_compensation import with_motor_laws

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Motion
    from flexros.robot import Robot

PERIODIC = 0
"""Place of periodic errors on the way from motor to log, see `AbstractSensor.rank`; quantization comes after."""


def compensated(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw], sample_time: float) -> Motion:
    """Change a motion such that a robot with the effects follows the path of the one without.

    Effects that change the model are part of the robot and thereby of its motion. The laws are undone from the arm to
    the command: gear, motor, encoder.

    Args:
        motion: The whole motion of the robot without the laws.
        robot: That robot.
        laws: Laws on it; one that is switched off changes nothing.
        sample_time: Distance of the samples [s].

    Returns:
        The motion with the laws; what `uncompensated` names is left out.
    """
    active = [law for law in laws if not law.effect.neutral]
    motion = with_gear_laws(motion, robot, active, sample_time)
    motion = with_motor_laws(motion, robot, active, sample_time)
    return _as_encoders_tell(motion, robot, active)


def motor_delays(robot: Robot, laws: Sequence[PlacedLaw]) -> tuple[float, ...]:
    """Give the time until a command acts, of each motor.

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


def laws_of_the_arm(laws: Sequence[PlacedLaw]) -> tuple[PlacedLaw, ...]:
    """Pick the laws that are part of the arm's equations: forces on it, and errors of its kinematics."""
    return tuple(
        law
        for law in laws
        if not law.effect.neutral and (acts_at_once(law) or isinstance(law.effect, AbstractToolError))
    )


def _as_encoders_tell(motion: Motion, robot: Robot, laws: Sequence[PlacedLaw]) -> Motion:
    """Turn motor positions into what encoders with periodic errors read there."""
    position, velocity = motion.motor_position.copy(), motion.motor_velocity.copy()
    q, v = ca.SX.sym("q"), ca.SX.sym("v")
    for number, name in enumerate(robot.joint_names):
        turns = robot.chain.motor(number).gear_ratio.value if robot.spec.coordinates == "arm" else 1.0
        read = q
        for law in laws:
            if law.location == name and isinstance(law.effect, AbstractSensor) and law.effect.rank == PERIODIC:
                read = law.effect.read(read, turns * q, law.effect.numbers)
        reading = ca.Function("reading", [q, v], [read, ca.jtimes(read, q, v)])
        rows = reading.call([ca.DM(array[np.newaxis, :, number]) for array in (position, velocity)])
        position[:, number], velocity[:, number] = (np.array(row).ravel() for row in rows)
    return replace(motion, motor_position=position, motor_velocity=velocity)
