"""Bounded least squares from normal equations: Levenberg-Marquardt inside a box of limited steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray, FloatArray

DAMPING = 1e-2
"""Initial damping, relative to the diagonal of the Gauss-Newton matrix (chosen)."""

SMALLEST_DAMPING = 1e-9
LARGEST_DAMPING = 1e9
"""Above this damping no step lowers the cost: the search has converged."""


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
        """Whether cost, gradient and Hessian are finite, so that a step can be computed."""
        return bool(np.isfinite(self.cost) and np.all(np.isfinite(self.gradient)) and np.all(np.isfinite(self.hessian)))


@dataclass(frozen=True)
class StopRule:
    """Stop rule of a search.

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
    """Result of a search.

    Attributes:
        x: Parameters, shape (P,).
        cost: Cost at x.
        iterations: Accepted steps.
        evaluations: Evaluations of the cost, with and without derivatives.
        converged: Whether a step or decrease fell below its limit; false if a limit of steps was reached.
        damping: Final damping, to start a search nearby.
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

    Each step minimises the damped quadratic model over the box of bounds and largest steps: parameters that reach a
    side are fixed there and the others are solved again. After a rejected step, the next one is evaluated by its cost
    alone, without derivatives.

    Args:
        equations: Normal equations at a point.
        cost: The cost alone; like that of the equations it may be infinite or NaN where the model fails.
        start: Initial parameters, within the bounds, shape (P,).
        lower: Lower bounds, shape (P,); -inf for none.
        upper: Upper bounds, shape (P,).
        largest_step: Largest change of each parameter in one step, shape (P,); inf for none.
        stop: Stop rule.
        damping: Initial damping, relative to the diagonal of H.

    Returns:
        The point of lowest cost; the initial point, not converged, where the model fails there.
    """
    x, current = start, equations(start)
    iterations, evaluations, growth, idle, trusted = 0, 1, 2.0, 0, True
    while current.known and iterations < stop.iterations and evaluations < stop.evaluations:
        step = box_step(current, damping, np.maximum(lower - x, -largest_step), np.minimum(upper - x, largest_step))
        size = float(np.max(np.abs(step), initial=0.0))
        predicted = -float(current.gradient @ step + 0.5 * step @ current.hessian @ step)
        if size < stop.step or damping > LARGEST_DAMPING:
            return Minimum(x, current.cost, iterations, evaluations, True, min(damping, DAMPING))
        if predicted <= 0:  # the box made it an ascent direction
            damping, growth = damping * growth, growth * 2.0
            continue
        trial = np.clip(x + step, lower, upper)
        new = equations(trial) if trusted else None
        reached = cost(trial) if new is None else new.cost
        evaluations += 1
        gain = (current.cost - reached) / predicted
        trusted = bool(np.isfinite(reached) and gain > 1e-4)
        if trusted:
            idle = idle + 1 if current.cost - reached < stop.decrease * current.cost else 0
            x, current = trial, equations(trial) if new is None else new
            iterations, growth = iterations + 1, 2.0
            damping = max(damping * max(1.0 / 5.0, 1.0 - (2.0 * gain - 1.0) ** 3), SMALLEST_DAMPING)
            if idle >= 2:
                return Minimum(x, current.cost, iterations, evaluations, True, damping)
        else:
            damping, growth = damping * growth, growth * 2.0
    return Minimum(x, current.cost, iterations, evaluations, False, damping)


def box_step(current: NormalEquations, damping: float, lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """Minimise the damped quadratic model over a box around the current point.

    Args:
        current: The quadratic model.
        damping: Damping relative to the diagonal of H.
        lowest: Most negative step of each parameter, <= 0, shape (P,).
        highest: Most positive step of each parameter, >= 0, shape (P,).

    Returns:
        Step, shape (P,).
    """
    diagonal = np.diag(current.hessian)
    floor = 1e-14 * float(np.max(diagonal, initial=0.0))
    damped = current.hessian + np.diag(damping * np.maximum(diagonal, floor) + floor + np.finfo(float).tiny)
    step = np.zeros_like(current.gradient)
    free: BoolArray = ~(((lowest >= 0) & (current.gradient > 0)) | ((highest <= 0) & (current.gradient < 0)))
    while np.any(free):
        fixed = ~free
        right = -current.gradient[free] - damped[np.ix_(free, fixed)] @ step[fixed]
        step[free] = np.linalg.solve(damped[np.ix_(free, free)], right)
        outside = free & ((step < lowest) | (step > highest))
        if not np.any(outside):
            break
        step[outside] = np.clip(step[outside], lowest[outside], highest[outside])
        free &= ~outside
    return step
