"""The search of the paper: a general-purpose quasi-Newton method without bounds, as a peer of the one used here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize

from flexros.errors import InputError
from flexros.identify.graybox.fit import cost_at
from flexros.identify.graybox.least_squares import least_squares

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.graybox.problem import GrayBoxProblem

STEPS = 200
"""Most steps of a search (chosen)."""

FARTHEST = float(np.log(1e4))
"""Change of a scaled parameter beyond which the cost rises by a parabola: no bound of interest, but no time is lost."""

_FAILED = 1e30
"""Cost where the model cannot be evaluated, so that the line search turns back."""


def quasi_newton(problem: GrayBoxProblem, start: FloatArray) -> FloatArray:
    """Search with SciPy's BFGS in the scaled parameters, with exact gradient, at the rests of the robot's own values.

    The paper used fminunc of MATLAB, which is of the same kind (Moberg 2007, Paper A, section 5.3).

    Args:
        problem: What to fit.
        start: Start [SI], shape (P,).

    Returns:
        Values where it ended [SI], shape (P,).
    """
    scale = problem.scale
    squares, nominal = least_squares(problem.model, problem.target), scale.scaled(scale.nominal)
    squares_at_start = squares.cost(start)

    def cost(x: FloatArray) -> tuple[float, FloatArray]:
        inside = np.clip(x, nominal - FARTHEST, nominal + FARTHEST)
        beyond = x - inside
        values = scale.values(inside)
        try:
            here = squares.normal_equations(values, scale.per_value(values))
        except np.linalg.LinAlgError:  # values out of all proportion
            return _FAILED, np.zeros_like(x)
        known = np.isfinite(here.cost) and np.all(np.isfinite(here.gradient))
        if not known:
            return _FAILED, np.zeros_like(x)
        wall = squares_at_start * float(beyond @ beyond)
        return here.cost + wall, np.where(beyond == 0, here.gradient, 2.0 * squares_at_start * beyond)

    with np.errstate(all="ignore"):
        result = minimize(cost, scale.scaled(start), jac=True, method="BFGS", options={"maxiter": STEPS})
        return scale.values(np.asarray(result.x, dtype=float))


def judged(problem: GrayBoxProblem, values: FloatArray) -> float:
    """Return the cost of a model at its own rests; infinite where it has none.

    Args:
        problem: The problem by whose cost models are judged.
        values: Values [SI], shape (P,).
    """
    try:
        with np.errstate(all="ignore"):
            cost = cost_at(problem, problem.model_at(values), values)
    except (InputError, np.linalg.LinAlgError):  # springs too soft for gravity, or values out of all proportion
        return np.inf
    return cost if np.isfinite(cost) else np.inf
