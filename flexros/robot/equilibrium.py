"""Equilibria of a robot under gravity, for given arm coordinates or given motor positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot


def at_arm_position(robot: Robot, q_a: FloatArray) -> FloatArray:
    """Compute the equilibrium for given actuated arm coordinates, with the other directions and the gears deflected.

    Args:
        robot: The robot.
        q_a: Arm coordinates [rad or m], shape (N,); initial values for the directions without motor.

    Returns:
        State at rest, shape (2 n_coordinates,).

    Raises:
        InputError: No equilibrium was found.
    """
    condition = f"at arm coordinates {np.round(q_a, 6).tolist()}"
    return robot.equilibrium_with_gears_held.find(_unloaded(robot, q_a), robot.model.parameter_values, condition).state


def at_motor_position(robot: Robot, motor_position: FloatArray, near: FloatArray) -> FloatArray:
    """Compute the equilibrium for given motor positions; the arm deflects on the springs.

    Args:
        robot: The robot.
        motor_position: Motor positions [rad or m], shape (M,).
        near: Initial arm coordinates, shape (N,).

    Returns:
        State at rest, shape (2 n_coordinates,).

    Raises:
        InputError: The motor positions are not M finite numbers, or no equilibrium was found.
    """
    if motor_position.shape != (robot.n_motors,) or not np.all(np.isfinite(motor_position)):
        raise InputError(
            f"motor positions are {motor_position.tolist()}, but robot {robot.name} needs {robot.n_motors} finite "
            f"numbers ({', '.join(robot.joint_names)}); correct them"
        )
    q_a = near.copy()
    q_a[list(robot.gear_rows)] = motor_position
    condition = f"at motor positions {np.round(motor_position, 6).tolist()}"
    return robot.equilibrium_with_motors_held.find(_unloaded(robot, q_a), robot.model.parameter_values, condition).state


def holding_torque(robot: Robot, state: FloatArray) -> FloatArray:
    """Return the motor torque [Nm or N], shape (M,), that holds a state at rest of shape (2 n_coordinates,)."""
    return robot.equilibrium_with_motors_held.holding_torque(state[: robot.n_coordinates], robot.model.parameter_values)


def _unloaded(robot: Robot, q_a: FloatArray) -> FloatArray:
    """Return coordinates [q_a, q_m] with unloaded gears."""
    flexible = [robot.gear_rows[number] for number in robot.flexible_motors]
    return np.concatenate([q_a, q_a[flexible]])
