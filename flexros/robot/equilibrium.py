"""Rest under gravity: where springs, gravity and motors balance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
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
    geared = [index for index, joint in enumerate(robot.chain.joints) if joint.motor is not None]
    start = np.concatenate([q_a, _motors_behind_gears(robot, q_a)])
    return _solve(robot, start, held=geared, place=f"arm coordinates {np.round(q_a, 6).tolist()}")


def at_motor_position(robot: Robot, motor_position: FloatArray, near: FloatArray) -> FloatArray:
    """Hold the motors; the arm hangs on the springs.

    Args:
        robot: The robot.
        motor_position: Motor positions [rad or m], shape (M,).
        near: Arm coordinates to start from, shape (N,).

    Returns:
        State at rest, shape (2 n_coordinates,).

    Raises:
        InputError: No rest was found.
    """
    joints = robot.chain.joints
    q_a = near.copy()
    for index, joint in enumerate(joints):
        if joint.motor is not None:
            q_a[index] = motor_position[joint.motor]
    start = np.concatenate([q_a, _motors_behind_gears(robot, q_a)])
    rigid = [i for i, joint in enumerate(joints) if joint.motor is not None and joint.motor_coordinate is None]
    held = rigid + list(range(robot.n_arm, robot.n_coordinates))
    return _solve(robot, start, held=held, place=f"motor positions {np.round(motor_position, 6).tolist()}")


def holding_torque(robot: Robot, state: FloatArray) -> FloatArray:
    """Motor torque that keeps a state at rest.

    Args:
        robot: The robot.
        state: State at rest, shape (2 n_coordinates,).

    Returns:
        Torque [Nm or N], shape (M,).
    """
    q = state[: robot.n_coordinates]
    force = _force(robot, q, np.zeros(robot.n_motors))
    torque = np.zeros(robot.n_motors)
    for index, joint in enumerate(robot.chain.joints):
        if joint.motor is not None:
            row = index if joint.motor_coordinate is None else robot.n_arm + joint.motor_coordinate
            torque[joint.motor] = -force[row]
    return torque


def _motors_behind_gears(robot: Robot, q_a: FloatArray) -> FloatArray:
    """Motor coordinates of unloaded springs."""
    joints = enumerate(robot.chain.joints)
    return np.array([q_a[index] for index, joint in joints if joint.motor_coordinate is not None])


def _force(robot: Robot, q: FloatArray, u: FloatArray) -> FloatArray:
    model = robot.model
    zero = np.zeros(robot.n_coordinates)
    return np.asarray(model.force(q, zero, u, np.zeros(6), model.parameter_values), dtype=float).ravel()


def _solve(robot: Robot, start: FloatArray, held: list[int], place: str) -> FloatArray:
    """Damped Newton on the arm's balance of forces, over all coordinates but the held ones.

    A held arm coordinate behind a rigid gear carries its own balance by the motor, so its row is left out.
    """
    model = robot.model
    q, v = ca.SX.sym("q", robot.n_coordinates), np.zeros(robot.n_coordinates)
    force = model.force(q, v, np.zeros(robot.n_motors), np.zeros(6), model.parameter_values)
    joints = robot.chain.joints
    rows = [i for i, joint in enumerate(joints) if joint.motor is None or joint.motor_coordinate is not None]
    free = [i for i in range(robot.n_coordinates) if i not in held]
    residual = force[rows] if rows else ca.SX(0, 1)
    evaluate = ca.Function("balance", [q], [residual, ca.jacobian(residual, q)[:, free]])
    value = start.copy()
    for _ in range(100 if rows else 0):
        error, slope = (np.asarray(part, dtype=float) for part in evaluate(value))
        step, *_ = np.linalg.lstsq(slope, -error.ravel(), rcond=None)
        value[free] += step * min(1.0, 0.2 / max(np.max(np.abs(step)), 1e-300))
        if np.max(np.abs(step)) < 1e-13 * (1.0 + np.max(np.abs(value))):
            break
    if rows:
        left, slope = (np.asarray(part, dtype=float) for part in evaluate(value))
        if np.max(np.abs(left)) > 1e-9 * (1.0 + np.max(np.abs(slope))):
            raise InputError(
                f"robot {robot.name} finds no rest at {place}: its springs do not balance gravity there "
                f"(a force of {np.max(np.abs(left)):.3g} N or Nm is left); check stiffness, masses and the pose"
            )
    return np.concatenate([value, v])
