"""Influences on an axis that the model of one axis lacks: gravity, and motion of other motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot

MOVES = 0.1
"""Speed of another motor, relative to that of the axis (rms), above which it is reported (chosen)."""

LOADS = 0.01
"""Holding torque at home, relative to the torque of the axis (rms), above which gravity is reported (chosen)."""


def unmodelled(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    """Find gravity on the axis, and motion of other motors.

    Args:
        record: Record of the log.
        robot: The nominal robot.
        motor: Number of the motor (0-based).

    Returns:
        One sentence for each; empty where neither is significant.
    """
    return (*_gravity(record, robot, motor), *_other_motion(record, robot, motor))


def _gravity(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    holding = robot.holding_torque(robot.equilibrium(robot.home))[motor]
    rms = np.sqrt(np.mean(record.torque[:, motor] ** 2))
    if abs(holding) <= LOADS * rms:
        return ()
    return (
        f"gravity loads {robot.joint_names[motor]} by {abs(holding):.3g} at home, but the model of the axis has no "
        "gravity; take an axis that gravity does not load, or a constant torque (offset) where it moves little",
    )


def _other_motion(record: Record, robot: Robot, motor: int) -> tuple[str, ...]:
    speed = np.sqrt(np.mean(np.diff(record.position, axis=0) ** 2, axis=0))
    moving = [
        name for other, name in enumerate(robot.joint_names) if other != motor and speed[other] > MOVES * speed[motor]
    ]
    if not moving:
        return ()
    joint = robot.joint_names[motor]
    return (f"the model of the axis has no other motion, but {', '.join(moving)} moves too; move {joint} alone",)
