"""Physically feasible bodies, rotors and friction that solve linear equations best.

A body is feasible exactly where its pseudo-inertia [[S, h], [h', m]], S = tr(L) E / 2 - L, is positive definite (P. M.
Wensing, S. Kim and J.-J. E. Slotine, 2018). It is linear in the parameters, so that the feasible robot that explains a
torque best is the solution of a semidefinite program.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray

FULLNESS = 1e-3
"""Weight of log det of the pseudo-inertias against the sum of squares [1] (chosen): on the border of what is feasible a
body is flat, and a simulated joint that carries almost no inertia diverges. Of parameters that solve the equations
almost equally well, it takes those of fuller bodies."""


def feasible_parameters(
    nominal: FloatArray, bodies: Mapping[str, list[int]], positive: list[int], wanted: FloatArray, weights: FloatArray
) -> FloatArray | None:
    """Search the feasible parameters of a robot that solve linear equations best.

    Args:
        nominal: Parameters of a feasible robot, shape (P,).
        bodies: Indices of the inertia at the joint (xx, yy, zz, xy, xz, yz), first moment and mass of each body.
        positive: Indices of further parameters that are not negative; all others stay nominal.
        wanted: Right-hand sides, shape (n,).
        weights: Matrix of the equations, shape (n, P).

    Returns:
        The parameters, shape (P,); None where a nominal body is not feasible, as one without inertia, or where no
        solution is found.
    """
    import cvxpy as cp  # here, because it loads slowly

    if any(np.linalg.eigvalsh(_pseudo_inertia(nominal[rows])).min() <= 0 for rows in bodies.values()):
        return None
    free = [*(index for rows in bodies.values() for index in rows), *positive]
    size = np.linalg.norm(weights[:, free], axis=0)
    size[size == 0] = 1.0
    factor, turned = np.linalg.qr(weights[:, free] / size), wanted - weights @ _without(nominal, free)
    x = cp.Variable(len(free))
    constraints = [x[10 * len(bodies) :] >= 0] if positive else []
    fullness = []
    for number in range(len(bodies)):
        rows = slice(10 * number, 10 * number + 10)
        span = _pseudo_inertia(nominal[free[rows]])
        half = np.diag(1 / np.sqrt(np.diag(span)))  # so that its entries are about 1
        terms = [x[rows.start + k] / size[rows.start + k] * (half @ _DIRECTIONS[k] @ half) for k in range(10)]
        fullness.append(cp.log_det(cp.sum(terms)))
    misfit = cp.sum_squares(factor.R @ x - factor.Q.T @ turned)
    problem = cp.Problem(cp.Minimize(misfit - FULLNESS * cp.sum(fullness)), constraints)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # an inaccurate solution is one to compare with others too
            problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    if x.value is None:
        return None
    found = nominal.copy()
    found[free] = np.asarray(x.value) / size
    found[positive] = np.maximum(found[positive], 0.0)
    return found


def _without(nominal: FloatArray, free: list[int]) -> FloatArray:
    """Return the nominal parameters with zeros for the free ones, shape (P,)."""
    rest = nominal.copy()
    rest[free] = 0.0
    return rest


def _pseudo_inertia(body: FloatArray) -> FloatArray:
    """Return the pseudo-inertia of a body, shape (4, 4)."""
    return np.asarray(np.tensordot(body, _DIRECTIONS, axes=1))


def _directions() -> FloatArray:
    """Return the pseudo-inertias of the ten parameters of a body, shape (10, 4, 4)."""
    directions = np.zeros((10, 4, 4))
    for number, entry in enumerate(INERTIA_COMPONENTS):
        row, column = "xyz".index(entry[0]), "xyz".index(entry[1])
        directions[number, row, column] = directions[number, column, row] = -1.0
        if row == column:
            directions[number, :3, :3] += 0.5 * np.eye(3)
    for axis in range(3):
        directions[6 + axis, axis, 3] = directions[6 + axis, 3, axis] = 1.0
    directions[9, 3, 3] = 1.0
    return directions


_DIRECTIONS = _directions()
