"""Making up for effects that are laws beside the robot's model: what the reference changes, and what it cannot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.delay import Delay
from flexros.feedforward.gear_compensation import with_gear_laws
from flexros.feedforward.motor_compensation import with_motor_laws

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Motion
    from flexros.robot import Robot


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
    return with_motor_laws(motion, robot, active, sample_time)


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
