"""Rest of a robot under gravity, for given arm coordinates or given motor positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot


def at_arm_position(robot: Robot, q_a: FloatArray) -> FloatArray:
    """Hold the actuated arm coordinates; the other directions deflect and the motors wind up their springs.

    Args:
        robot: The robot.
        q_a: Arm coordinates [rad or m], shape (N,); start values of the directions without motor.

    Returns:
        State at rest, shape (2 n_coordinates,).

    Raises:
        InputError: No rest was found.
    """
    place = f"at arm coordinates {np.round(q_a, 6).tolist()}"
    return robot.rest_with_gears_held.find(_unloaded(robot, q_a), robot.model.parameter_values, place).state


def at_motor_position(robot: Robot, motor_position: FloatArray, near: FloatArray) -> FloatArray:
    """Hold the motors; the arm hangs on the springs.

    Args:
        robot: The robot.
        motor_position: Motor positions [rad or m], shape (M,).
        near: Arm coordinates to start from, shape (N,).

    Returns:
        State at rest, shape (2 n_coordinates,).

    Raises:
        InputError: The motor positions are not M finite numbers, or no rest was found.
    """
    if motor_position.shape != (robot.n_motors,) or not np.all(np.isfinite(motor_position)):
        raise InputError(
            f"motor positions are {motor_position.tolist()}, but robot {robot.name} needs {robot.n_motors} finite "
            f"numbers ({', '.join(robot.joint_names)}); correct them"
        )
    q_a = near.copy()
    q_a[list(robot.gear_rows)] = motor_position
    place = f"at motor positions {np.round(motor_position, 6).tolist()}"
    return robot.rest_with_motors_held.find(_unloaded(robot, q_a), robot.model.parameter_values, place).state


def holding_torque(robot: Robot, state: FloatArray) -> FloatArray:
    """Motor torque that keeps a state at rest.

    Args:
        robot: The robot.
        state: State at rest, shape (2 n_coordinates,).

    Returns:
        Torque [Nm or N], shape (M,).
    """
    return robot.rest_with_motors_held.holding_torque(state[: robot.n_coordinates], robot.model.parameter_values)


def _unloaded(robot: Robot, q_a: FloatArray) -> FloatArray:
    """Coordinates [q_a, q_m] with the gears' springs unloaded."""
    flexible = [robot.gear_rows[number] for number in robot.flexible_motors]
    return np.concatenate([q_a, q_a[flexible]])
