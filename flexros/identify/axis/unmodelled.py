"""What acts on an axis in a log that the model of one axis does not have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.robot import Robot

MOVES = 0.1
"""Speed of another motor, relative to that of the axis (rms), from which it is said to move too (chosen)."""

LOADS = 0.01
"""Torque that gravity needs at home, relative to the command (rms), from which it is told (chosen)."""


def unmodelled(log: Log, robot: Robot, joint: str) -> tuple[str, ...]:
    """Find gravity on the axis, and motion of other motors.

    Args:
        log: Log of the axis, with the joint and its commands.
        robot: The robot as it is thought to be.
        joint: Name of the motor.

    Returns:
        One sentence for each; none where the axis is alone.
    """
    return (*_gravity(log, robot, joint), *_others(log, joint))


def _gravity(log: Log, robot: Robot, joint: str) -> tuple[str, ...]:
    commands = log.joint_commands
    if commands is None or commands.effort is None:
        return ()
    held = robot.holding_torque(robot.equilibrium(robot.home))[robot.joint_names.index(joint)]
    rms = np.sqrt(np.mean(commands.effort[:, commands.names.index(joint)] ** 2))
    if abs(held) <= LOADS * rms:
        return ()
    return (
        f"gravity loads {joint} by {abs(held):.3g} at home, but the model of the axis has no gravity; take an axis "
        "that gravity does not load, or a constant torque (offset) where it moves little",
    )


def _others(log: Log, joint: str) -> tuple[str, ...]:
    states = log.joint_states
    if states.position is None:
        return ()
    speed = dict(zip(states.names, np.sqrt(np.mean(np.diff(states.position, axis=0) ** 2, axis=0)), strict=True))
    moved = [name for name, rms in speed.items() if name != joint and rms > MOVES * speed[joint]]
    if not moved:
        return ()
    return (f"the model of the axis knows no other motion, but {', '.join(moved)} moves too; move {joint} alone",)
