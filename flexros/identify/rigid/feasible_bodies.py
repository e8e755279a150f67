"""Physically feasible bodies, rotors and friction nearest to base parameters that no robot has.

A body is feasible exactly where its pseudo-inertia [[S, h], [h', m]], S = tr(L) E / 2 - L, is positive definite (P. M.
Wensing, S. Kim and J.-J. E. Slotine, 2018). It is linear in the parameters, so that the nearest feasible robot is the
solution of a convex problem: the logarithm of the determinant is a barrier (S. Boyd and L. Vandenberghe, 2004, 11.3).
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray

LOWERED, ROUNDS = 0.2, 60
"""Factor of the weight of the barriers from one round to the next [1], and most rounds (chosen)."""

GAP = 1e-4
"""Largest share of the misfit by which that of the best feasible parameters may be smaller [1] (chosen)."""

STEPS = 50
"""Most Newton steps of a round (chosen)."""

ENOUGH = 1e-6
"""Decrement of a Newton step, over the weight of the barriers, with which a round ends [1] (chosen)."""


def feasible_parameters(
    nominal: FloatArray, bodies: Mapping[str, list[int]], positive: list[int], wanted: FloatArray, weights: FloatArray
) -> FloatArray | None:
    """Search the feasible parameters of a robot that solve linear equations best.

    Args:
        nominal: Parameters to begin with, shape (P,).
        bodies: Indices of the inertia at the joint (xx, yy, zz, xy, xz, yz), first moment and mass of each body.
        positive: Indices of further parameters that are not negative; all others stay nominal.
        wanted: Right-hand sides, shape (n,).
        weights: Matrix of the equations, shape (n, P).

    Returns:
        The parameters, shape (P,); None where a body is not feasible to begin with, as one without inertia.
    """
    begin = nominal.copy()
    typical = np.abs(nominal[positive]).max(initial=0.0) or 1.0
    begin[positive] = np.maximum(nominal[positive], 0.01 * typical)
    free = [*(index for rows in bodies.values() for index in rows), *positive]
    if any(_cholesky(_pseudo(begin[rows])) is None for rows in bodies.values()):
        return None
    rest = wanted - weights @ np.where(np.isin(np.arange(len(nominal)), free), 0.0, nominal)
    size = np.linalg.norm(weights[:, free], axis=0)
    size[size == 0] = 1.0
    H, g = weights[:, free] / size, rest
    parts = [slice(10 * k, 10 * k + 10) for k in range(len(bodies))]
    search = _Search(H.T @ H, H.T @ g, parts, size)
    x = begin[free] * size
    weight, barriers = _misfit(H, x, g), 4 * len(bodies) + len(positive)
    for _ in range(ROUNDS):
        x = search.centre(x, weight)
        if barriers * weight <= GAP * _misfit(H, x, g):  # how far the misfit is from the least one at most
            break
        weight *= LOWERED
    found = nominal.copy()
    found[free] = x / size
    return found


def _misfit(matrix: FloatArray, x: FloatArray, right: FloatArray) -> float:
    return 0.5 * float(np.sum((matrix @ x - right) ** 2))


class _Search:
    """Newton steps of a quadratic misfit with barriers.

    Args:
        normal: Normal matrix of the scaled parameters, shape (k, k).
        right: Right-hand side, shape (k,).
        bodies: Which of them are those of each body; the others are not negative.
        size: What each is scaled with, shape (k,).
    """

    def __init__(self, normal: FloatArray, right: FloatArray, bodies: list[slice], size: FloatArray) -> None:
        self._normal, self._right, self._bodies, self._size = normal, right, bodies, size
        self._others = slice(10 * len(bodies), len(right))

    def centre(self, x: FloatArray, weight: float) -> FloatArray:
        """Return the parameters with the least misfit and barriers, shape (k,), from feasible ones."""
        for _ in range(STEPS):
            gradient, curvature = self._derivatives(x, weight)
            step = np.asarray(-np.linalg.lstsq(curvature, gradient, rcond=None)[0], dtype=float)
            slope = float(gradient @ step)
            if -slope < ENOUGH * weight:
                break
            share = _share(partial(self._along, x, step, weight), self._value(x, weight), slope)
            if share == 0.0:
                break
            x = x + share * step
        return x

    def _along(self, x: FloatArray, step: FloatArray, weight: float, share: float) -> float:
        """Return misfit and barriers after a share of a step."""
        return self._value(x + share * step, weight)

    def _value(self, x: FloatArray, weight: float) -> float:
        """Return misfit and barriers; infinite where the parameters are not feasible."""
        value = 0.5 * float(x @ self._normal @ x) - float(self._right @ x)
        if np.any(x[self._others] <= 0):
            return float("inf")
        value -= weight * float(np.sum(np.log(x[self._others])))
        for part in self._bodies:
            lower = _cholesky(_pseudo(x[part] / self._size[part]))
            if lower is None:
                return float("inf")
            value -= 2 * weight * float(np.sum(np.log(np.diag(lower))))
        return value

    def _derivatives(self, x: FloatArray, weight: float) -> tuple[FloatArray, FloatArray]:
        gradient = self._normal @ x - self._right
        curvature = self._normal.copy()
        gradient[self._others] -= weight / x[self._others]
        others = np.arange(self._others.start, self._others.stop)
        curvature[others, others] += weight / x[self._others] ** 2
        for part in self._bodies:
            inverse = np.linalg.inv(_pseudo(x[part] / self._size[part]))
            sides = inverse @ _DIRECTIONS / self._size[part][:, None, None]
            gradient[part] -= weight * np.trace(sides, axis1=1, axis2=2)
            curvature[part, part] += weight * np.einsum("aij,bji->ab", sides, sides)
        return gradient, curvature


def _share(value: Callable[[float], float], begin: float, slope: float) -> float:
    """Return the share of a step that lowers a value enough; zero where none does."""
    share = 1.0
    while share > np.finfo(float).eps:
        if value(share) <= begin + 0.01 * share * slope:
            return share
        share /= 2
    return 0.0


def _pseudo(body: FloatArray) -> FloatArray:
    """Return the pseudo-inertia of a body, shape (4, 4)."""
    return np.asarray(np.tensordot(body, _DIRECTIONS, axes=1))


def _cholesky(matrix: FloatArray) -> FloatArray | None:
    try:
        return np.asarray(np.linalg.cholesky(matrix), dtype=float)
    except np.linalg.LinAlgError:
        return None


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
