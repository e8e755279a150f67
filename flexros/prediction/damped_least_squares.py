"""Least squares with bounds from normal equations: Levenberg and Marquardt inside a box of limited steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray, FloatArray

DAMPING = 1e-2
"""Damping to start with, relative to the diagonal of the Gauss-Newton matrix (chosen)."""

SMALLEST_DAMPING = 1e-9
LARGEST_DAMPING = 1e9
"""Beyond this no step however short lowers the cost: the search ends."""


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Cost and its Gauss-Newton model c + g^T s + s^T H s / 2 about a point.

    Attributes:
        cost: Sum of weighted squares.
        gradient: g, shape (P,).
        hessian: H, shape (P, P).
    """

    cost: float
    gradient: FloatArray
    hessian: FloatArray

    @property
    def known(self) -> bool:
        """Whether all of it is finite, so that there is a step to take."""
        return bool(np.isfinite(self.cost) and np.all(np.isfinite(self.gradient)) and np.all(np.isfinite(self.hessian)))


@dataclass(frozen=True)
class StopRule:
    """When a search ends.

    Attributes:
        step: Converged where the largest change of a parameter falls below this.
        decrease: Converged where the relative decrease of the cost stays below this for two steps.
        iterations: Largest number of accepted steps.
        evaluations: Largest number of evaluations of the cost.
    """

    step: float = 1e-7
    decrease: float = 1e-9
    iterations: int = 200
    evaluations: int = 600


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a search ended.

    Attributes:
        x: Parameters, shape (P,).
        cost: Cost there.
        iterations: Accepted steps.
        evaluations: Evaluations of the cost, with and without derivatives.
        converged: Whether a step or decrease fell below the limit, instead of the numbers running out.
        damping: Damping at the end, to start a search nearby.
    """

    x: FloatArray
    cost: float
    iterations: int
    evaluations: int
    converged: bool
    damping: float


def minimise(
    equations: Callable[[FloatArray], NormalEquations],
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    largest_step: FloatArray,
    stop: StopRule,
    damping: float = DAMPING,
) -> Minimum:
    """Minimise a sum of squares within bounds (Levenberg 1944, Marquardt 1963; damping after Nielsen 1999).

    Each step minimises the damped quadratic model over the box of bounds and largest steps: what runs into a side is
    fixed there and the rest solved again. After a step that failed only the cost of the next one is evaluated first.

    Args:
        equations: Normal equations at a point.
        cost: The cost alone; may, as that of the equations, be infinite or NaN where the model fails.
        start: Where to start, within the bounds, shape (P,).
        lower: Lower bounds, shape (P,); -inf for none.
        upper: Upper bounds, shape (P,).
        largest_step: Largest change of each parameter in one step, shape (P,); inf for none.
        stop: When to end.
        damping: Damping to start with, relative to the diagonal of H.

    Returns:
        The point of lowest cost that was found; the start, not converged, where the model fails there.
    """
    x, here = start, equations(start)
    iterations, evaluations, growth, idle, trusted = 0, 1, 2.0, 0, True
    while here.known and iterations < stop.iterations and evaluations < stop.evaluations:
        step = box_step(here, damping, np.maximum(lower - x, -largest_step), np.minimum(upper - x, largest_step))
        size = float(np.max(np.abs(step), initial=0.0))
        predicted = -float(here.gradient @ step + 0.5 * step @ here.hessian @ step)
        if size < stop.step or damping > LARGEST_DAMPING:
            return Minimum(x, here.cost, iterations, evaluations, True, min(damping, DAMPING))
        if predicted <= 0:  # the box bent the step uphill
            damping, growth = damping * growth, growth * 2.0
            continue
        trial = np.clip(x + step, lower, upper)
        there = equations(trial) if trusted else None
        reached = cost(trial) if there is None else there.cost
        evaluations += 1
        gain = (here.cost - reached) / predicted
        trusted = bool(np.isfinite(reached) and gain > 1e-4)
        if trusted:
            idle = idle + 1 if here.cost - reached < stop.decrease * here.cost else 0
            x, here = trial, equations(trial) if there is None else there
            iterations, growth = iterations + 1, 2.0
            damping = max(damping * max(1.0 / 5.0, 1.0 - (2.0 * gain - 1.0) ** 3), SMALLEST_DAMPING)
            if idle >= 2:
                return Minimum(x, here.cost, iterations, evaluations, True, damping)
        else:
            damping, growth = damping * growth, growth * 2.0
    return Minimum(x, here.cost, iterations, evaluations, False, damping)


def box_step(here: NormalEquations, damping: float, lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """Minimise the damped quadratic model over a box around the present point.

    Args:
        here: The quadratic model.
        damping: Damping relative to the diagonal of H.
        lowest: Most negative step of each parameter, <= 0, shape (P,).
        highest: Most positive step of each parameter, >= 0, shape (P,).

    Returns:
        Step, shape (P,).
    """
    diagonal = np.diag(here.hessian)
    floor = 1e-14 * float(np.max(diagonal, initial=0.0))
    damped = here.hessian + np.diag(damping * np.maximum(diagonal, floor) + floor + np.finfo(float).tiny)
    step = np.zeros_like(here.gradient)
    free: BoolArray = ~(((lowest >= 0) & (here.gradient > 0)) | ((highest <= 0) & (here.gradient < 0)))
    while np.any(free):
        fixed = ~free
        right = -here.gradient[free] - damped[np.ix_(free, fixed)] @ step[fixed]
        step[free] = np.linalg.solve(damped[np.ix_(free, free)], right)
        outside = free & ((step < lowest) | (step > highest))
        if not np.any(outside):
            break
        step[outside] = np.clip(step[outside], lowest[outside], highest[outside])
        free &= ~outside
    return step
