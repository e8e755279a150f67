"""Consistent initial values of the DAE: rest under gravity with the tool at the start of the path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.time_stepping.dae_equations import DaeEquations
    from flexros.robot import Robot

MAX_ITERATIONS = 100
LARGEST_STEP = 0.2
TOLERANCE = 1e-14


def consistent_initial_values(
    robot: Robot, equations: DaeEquations, output: FloatArray, rigid: FloatArray
) -> FloatArray:
    """Solve the equations of motion and the output equation for rest.

    All explicit and hidden constraints are met: the trajectory starts with zero speed and acceleration, so rest in
    equilibrium satisfies their derivatives.

    Args:
        robot: The robot.
        equations: One step of the DAE; with gamma = 0 it describes rest.
        output: Controlled output at the start [m or rad], shape (n_out,).
        rigid: Arm coordinates of the rigid arm there [rad or m], shape (N,); initial value of the search.

    Returns:
        Unknowns z = [q_a, q_m, torque of stiff gears] in equilibrium, shape (n_unknowns,).

    Raises:
        InputError: There is no equilibrium near the rigid pose.
    """
    rest, zero = np.zeros(equations.n_coordinates), np.zeros(equations.n_unknowns)
    z = zero.copy()
    z[: robot.n_arm] = rigid
    z[list(robot.motor_rows)] = rigid[list(robot.gear_rows)]
    weight = 1.0 / _stiffness_scale(equations, z)
    for _ in range(MAX_ITERATIONS):
        matrix = np.array(equations.newton_matrix(zero, z, rest, rest, 0.0, weight))
        residual = np.array(equations.residual(zero, z, rest, rest, 0.0, weight, output)).ravel()
        try:
            step = np.linalg.solve(matrix, residual)
        except np.linalg.LinAlgError:
            break
        coordinates = step[: equations.n_coordinates]
        size = float(np.max(np.abs(coordinates)))
        z = z - step * min(1.0, LARGEST_STEP / max(size, LARGEST_STEP))
        if size <= TOLERANCE * (1.0 + float(np.max(np.abs(z[: equations.n_coordinates])))):
            return np.asarray(z)
        if not np.isfinite(size):
            break
    if np.isfinite(z).all() and size < 1e3 * TOLERANCE * (1.0 + float(np.max(np.abs(z)))):
        return np.asarray(z)
    raise InputError(
        f"robot {robot.name} has no equilibrium with its output at the start of the path, "
        f"{np.round(output, 6).tolist()}: its springs do not balance gravity there or the pose is singular; move the "
        "start of the path"
    )


def _stiffness_scale(equations: DaeEquations, z: FloatArray) -> float:
    """Return the largest stiffness [Nm/rad or N/m], the scale of the arm's equations relative to the output's."""
    rest, zero = np.zeros(equations.n_coordinates), np.zeros(equations.n_unknowns)
    matrix = np.array(equations.newton_matrix(zero, z, rest, rest, 0.0, 1.0))
    return float(np.max(np.abs(matrix[: equations.n_arm]))) or 1.0
