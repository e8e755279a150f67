"""Inverse dynamics of the rigid arm with its motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi
import numpy as np

if TYPE_CHECKING:
    from flexros.robot import Robot


def rigid_torque(robot: Robot, position: casadi.SX, speed: casadi.SX, acceleration: casadi.SX) -> casadi.SX:
    """Return the motor torques of the rigid robot, M(q) a + c(q, v) + g(q) (Moberg 2007, equation 3.9), SX (M, 1).

    All springs are rigid; M contains the inertia of arm and motors, c also viscous friction.

    Args:
        robot: The robot.
        position: Positions of the gears [rad or m], SX (M, 1).
        speed: Their rates, SX (M, 1).
        acceleration: Their accelerations, SX (M, 1).
    """
    model, embed = robot.model, embedding(robot)
    p, still, free = model.parameter_values, casadi.SX.zeros(robot.n_motors), casadi.SX.zeros(6)
    q, v, a = (casadi.mtimes(embed, part) for part in (position, speed, acceleration))
    whole = casadi.mtimes(model.mass_matrix(q, p), a) - model.force(q, v, still, free, p)
    return casadi.mtimes(embed.T, whole)


def gravity_torque(robot: Robot, position: casadi.SX) -> casadi.SX:
    """Return the torques at the gears that hold the arm against gravity [Nm or N], SX (M, 1).

    Args:
        robot: The robot; its directions without motor are taken as rigid.
        position: Positions of the gears [rad or m], SX (M, 1).
    """
    arm = casadi.SX(robot.arm_from_gears(position))
    still = casadi.SX.zeros(robot.n_arm)
    held = robot.model.arm_inverse_dynamics(arm, still, still, robot.model.parameter_values)
    return held[list(robot.gear_rows)]


def embedding(robot: Robot) -> casadi.DM:
    """Return the matrix from gear positions to all coordinates of the rigid robot, DM (n_coordinates, M)."""
    matrix = np.zeros((robot.n_coordinates, robot.n_motors))
    for motor in range(robot.n_motors):
        matrix[robot.gear_rows[motor], motor] = matrix[robot.motor_rows[motor], motor] = 1.0
    return casadi.DM(matrix)
