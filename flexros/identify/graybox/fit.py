"""Fit the unknown parameters of a robot to measured frequency responses (Moberg 2007, Paper A, section 5.3)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.identify.graybox.least_squares import least_squares
from flexros.prediction.damped_least_squares import DAMPING, Minimum, NormalEquations, StopRule, minimise

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.identify.graybox.problem import GrayBoxProblem

LARGEST_STEP = 1.0
"""Largest change of a logarithm in one step; without this limit a fit diverges where the cost is flat."""

FAILED = "the model cannot be evaluated at the initial values"
"""Message of a fit whose cost is not finite."""


@dataclass(frozen=True)
class FitSettings:
    """Search settings and stop rules of a fit.

    Attributes:
        stop: Stop rule of the search for fixed equilibria.
        relinearisations: Largest number of times that the robot is linearised again, at the equilibria of the fitted
            values; 0 keeps the equilibria of the nominal values.
        settled: Relative change of every value below which the robot is not linearised again.
    """

    stop: StopRule = field(default_factory=StopRule)
    relinearisations: int = 10
    settled: float = 1e-6


@dataclass(frozen=True, eq=False)
class GrayBoxFit:
    """Result of one fit.

    Attributes:
        names: Names of the parameters, length P.
        values: Fitted values [SI], shape (P,).
        start: Initial values [SI], shape (P,).
        cost: Weighted sum of squared errors (Moberg 2007, Paper A, equations 4b and 7b); not finite if the fit failed.
        start_cost: Cost at the initial values and the nominal equilibria; NaN where the model fails there.
        at_bound: Whether a parameter is on one of its bounds, shape (P,).
        lower: Lower bounds [SI], shape (P,).
        upper: Upper bounds [SI], shape (P,).
        iterations: Accepted steps, over all linearisations.
        evaluations: Evaluations of the cost.
        relinearisations: Number of relinearisations.
        converged: False if the limit of steps or of relinearisations was reached.
        message: Why the fit ended.
        estimator: Name of the estimator.
        weights: Kind of the weights.
    """

    names: tuple[str, ...]
    values: FloatArray
    start: FloatArray
    cost: float
    start_cost: float
    at_bound: BoolArray
    lower: FloatArray
    upper: FloatArray
    iterations: int
    evaluations: int
    relinearisations: int
    converged: bool
    message: str
    estimator: str
    weights: str

    def value(self, name: str) -> float:
        """Return the value of a parameter [SI], e.g. of "body_1.ry.stiffness".

        Raises:
            InputError: The parameter was not fitted.
        """
        if name not in self.names:
            raise unknown_name("fitted parameter", name, self.names)
        return float(self.values[self.names.index(name)])


def fit(
    problem: GrayBoxProblem,
    start: FloatArray | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    settings: FitSettings | None = None,
) -> GrayBoxFit:
    """Minimise the cost from one set of initial values.

    The robot is linearised at the equilibria of its nominal values and fitted, then linearised at the equilibria of the
    fitted values and fitted again until nothing changes (Moberg 2007, Paper A, remark A.1).

    Args:
        problem: Measured responses, unknown parameters, estimator and weights.
        start: Initial values [SI], shape (P,); default: the nominal values of the robot.
        bounds: Lower and upper bound of values [SI] by name; see `ParameterScale.bounds` for the default.
        settings: Search settings.

    Returns:
        The local minimum.

    Raises:
        InputError: `start` is not one finite number per parameter within the bounds, or the bounds are wrong.
    """
    settings = settings or FitSettings()
    scale = problem.scale
    lower, upper = scale.bounds(bounds)
    values = np.array(scale.nominal if start is None else start, dtype=float)
    x = _checked_start(problem, values, lower, upper)
    search = _Search(problem, lower, upper, settings)
    minimum, message, rounds = search.run(x)
    edge = 1e-9 * np.maximum(1.0, np.abs(minimum.x))
    return GrayBoxFit(
        names=problem.names,
        values=scale.values(minimum.x),
        start=values,
        cost=minimum.cost,
        start_cost=cost_at(problem, problem.model, values),
        at_bound=(minimum.x <= lower + edge) | (minimum.x >= upper - edge),
        lower=scale.values(lower),
        upper=scale.values(upper),
        iterations=minimum.iterations,
        evaluations=minimum.evaluations,
        relinearisations=rounds,
        converged=minimum.converged,
        message=message,
        estimator=problem.estimator.name,
        weights=problem.setting.kind,
    )


def cost_at(problem: GrayBoxProblem, model: FrequencyModel, values: FloatArray) -> float:
    """Evaluate the cost at parameter values.

    Args:
        problem: Measured responses, estimator and weights.
        model: Frequency model; `problem.model_at(values)` uses the equilibria of these values.
        values: Values [SI], shape (P,).

    Returns:
        Weighted sum of squared errors; NaN or infinite where the model fails.
    """
    try:
        return least_squares(model, problem.target).cost(values)
    except np.linalg.LinAlgError:  # singular mass matrix
        return np.nan


class _Search:
    """Outer loop over linearisations, inner loop over steps."""

    def __init__(self, problem: GrayBoxProblem, lower: FloatArray, upper: FloatArray, settings: FitSettings) -> None:
        self._problem, self._settings = problem, settings
        self._lower, self._upper = lower, upper
        self._largest = np.where(problem.scale.logarithmic, LARGEST_STEP, np.inf)

    def run(self, x: FloatArray) -> tuple[Minimum, str, int]:
        """Search from scaled parameters; return the minimum, the message and the number of relinearisations."""
        minimum = self._minimise(self._problem.model, x, DAMPING)
        if not np.isfinite(minimum.cost):
            return minimum, FAILED, 0
        for count in range(self._settings.relinearisations):
            try:
                model = self._problem.model_at(self._problem.scale.values(minimum.x))
            except InputError as error:
                return replace(minimum, converged=False), f"the robot could not be linearised again: {error}", count
            before = minimum
            minimum = _continued(self._minimise(model, before.x, before.damping), before)
            if self._settled(before, minimum):
                return minimum, _reason(minimum), count + 1
        if self._settings.relinearisations:
            return replace(minimum, converged=False), "the equilibria did not settle", self._settings.relinearisations
        return minimum, _reason(minimum), 0

    def _settled(self, before: Minimum, after: Minimum) -> bool:
        """Whether the last linearisation changed neither the parameters nor the cost."""
        moved = float(np.max(np.abs(after.x - before.x), initial=0.0))
        changed = abs(after.cost - before.cost)
        return moved < self._settings.settled or changed < self._settings.stop.decrease * before.cost

    def _minimise(self, model: FrequencyModel, x: FloatArray, damping: float) -> Minimum:
        squares, scale = least_squares(model, self._problem.target), self._problem.scale

        def equations(point: FloatArray) -> NormalEquations:
            values = scale.values(point)
            try:
                return squares.normal_equations(values, scale.per_value(values))
            except np.linalg.LinAlgError:  # singular mass matrix
                return NormalEquations(np.nan, np.full_like(point, np.nan), np.full((len(point),) * 2, np.nan))

        def cost(point: FloatArray) -> float:
            try:
                return squares.cost(scale.values(point))
            except np.linalg.LinAlgError:
                return np.nan

        return minimise(equations, cost, x, self._lower, self._upper, self._largest, self._settings.stop, damping)


def _continued(minimum: Minimum, before: Minimum) -> Minimum:
    """Add the steps and evaluations of the previous searches."""
    return replace(
        minimum,
        iterations=minimum.iterations + before.iterations,
        evaluations=minimum.evaluations + before.evaluations,
    )


def _reason(minimum: Minimum) -> str:
    if not np.isfinite(minimum.cost):
        return FAILED
    return "converged" if minimum.converged else "the limit of steps was reached"


def _checked_start(problem: GrayBoxProblem, values: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return the scaled initial values; reject values of wrong shape, not finite or outside the bounds."""
    scale = problem.scale
    if values.shape != (len(scale.names),) or not np.all(np.isfinite(values)):
        raise InputError(
            f"start has the values {values.tolist()}, allowed is one finite number for each of {len(scale.names)} "
            "unknown parameters; correct it"
        )
    for name, value, low, high in zip(scale.names, values, scale.values(lower), scale.values(upper), strict=True):
        slack = 1e-9 * max(abs(low), abs(high)) if np.isfinite(high) else 1e-9
        if not low - slack <= value <= high + slack:
            raise InputError(
                f"start of {name} is {value:g}, but its bounds are {low:g} and {high:g}; start within them or give "
                "wider bounds"
            )
    return np.clip(scale.scaled(values), lower, upper)
