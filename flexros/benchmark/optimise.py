"""Optimisation of controllers on the cost V with the demands as constraints, by CMA-ES."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from flexros.benchmark.demands import NOISE_TORQUE
from flexros.benchmark.evaluate import SEEDS
from flexros.benchmark.models import NOMINAL, RULES
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.benchmark.evaluate import FeedbackBenchmark
    from flexros.control.base import AbstractControlLaw

STABLE = 1.0 - 2e-4
"""Largest eigenvalue that the search accepts [1], chosen: motions decay at least with 0.4/s."""
ROOM = 0.02
"""Share of the limits of settling time and noise torque that the search keeps free [1] (chosen)."""
UNSTABLE, MISSED = 1e3, 1e2
"""Cost of an unstable loop, and per unit of a missed limit: above every stable design (chosen)."""
WIDEST = 14.0
"""Largest logarithm of a parameter that is tried [1] (chosen)."""


class Search(Protocol):
    """A controller as a function of a point of the search."""

    def __call__(self, point: FloatArray) -> AbstractControlLaw:
        """Return the law at a point, shape (n_parameters,).

        Raises:
            InputError: There is no controller at this point.
        """
        ...


@dataclass(frozen=True, eq=False)
class Optimum:
    """Best point of a search.

    Attributes:
        point: The point, shape (n_parameters,).
        cost: Its cost over the seeds of the search; part of V.
        evaluations: Number of laws tried.
    """

    point: FloatArray
    cost: float
    evaluations: int


def part_cost(benchmark: FeedbackBenchmark, law: AbstractControlLaw, part: str, seeds: Sequence[int]) -> float:
    """Return the share of V that a controller causes, with penalties for missed demands.

    Args:
        benchmark: The benchmark.
        law: The control law.
        part: "C1", which controls the nominal model, or "C2", which controls the sets M1 and M2.
        seeds: Seeds of the noise.

    Returns:
        0.6 V_nominal, or V_1 + 0.3 V_2; above `UNSTABLE` if a linear loop is unstable.
    """
    found = benchmark.stability.eigenvalues(law, nominal_only=part == "C1")
    radius = max(value for value, _ in found.values())
    if not radius < STABLE:
        return UNSTABLE * (1.0 + min(100.0 * (radius - STABLE), 100.0)) if np.isfinite(radius) else 2e2 * UNSTABLE
    cost = 0.0
    for name in (NOMINAL,) if part == "C1" else tuple(name for name in RULES if name != NOMINAL):
        rules = RULES[name]
        for run in benchmark.measures_of_set(name, law, seeds=seeds):
            late = max(0.0, float(np.max(run.settling)) - (1.0 - ROOM) * rules.deadline)
            noisy = max(0.0, run.noise_torque - (1.0 - ROOM) * NOISE_TORQUE)
            cost += (rules.weight * run.cost + MISSED * (late + noisy)) / len(seeds)
    return cost if np.isfinite(cost) else UNSTABLE


def optimise(
    benchmark: FeedbackBenchmark,
    search: Search,
    start: FloatArray,
    part: str,
    *,
    evaluations: int,
    step: float = 0.3,
    seed: int = 1,
    seeds: Sequence[int] = SEEDS[:1],
    progress: Callable[[int, float], None] | None = None,
) -> Optimum:
    """Search the best controller of a structure with CMA-ES (Hansen and Ostermeier 2001).

    Args:
        benchmark: The benchmark.
        search: The controller as a function of the point.
        start: First point, shape (n_parameters,).
        part: "C1" or "C2", see `part_cost`.
        evaluations: Number of laws to try.
        step: First standard deviation of the search [1].
        seed: Seed of the search.
        seeds: Seeds of the noise in the search; the result is evaluated on all.
        progress: Called with the number of laws tried and the best cost.

    Returns:
        The best point; it is the same for the same arguments on one machine.

    Raises:
        InputError: Fewer than one evaluation, or the package cma is missing.
    """

    def cost(point: FloatArray) -> float:
        if np.max(np.abs(point)) > WIDEST:
            return 3e2 * UNSTABLE
        try:
            return part_cost(benchmark, search(np.asarray(point)), part, seeds)
        except InputError:
            return 3e2 * UNSTABLE

    return minimised(cost, start, step, evaluations, seed=seed, progress=progress)


def minimised(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    step: float,
    evaluations: int,
    *,
    seed: int = 1,
    progress: Callable[[int, float], None] | None = None,
) -> Optimum:
    """Minimise a cost by CMA-ES.

    Args:
        cost: Cost of a point, shape (n_parameters,) -> value [1].
        start: First point, shape (n_parameters,).
        step: First standard deviation of the search [1].
        evaluations: Number of points to try.
        seed: Seed of the search.
        progress: Called with the number of points tried and the lowest cost.

    Returns:
        The best point; it is the same for the same arguments on one machine.

    Raises:
        InputError: Fewer than one evaluation, or the package cma is missing.
    """
    if evaluations < 1:
        raise InputError(f"{evaluations} evaluations were given, allowed is at least one; correct it", "evaluations")
    cma = _cma()
    options = {"maxfevals": evaluations, "seed": seed, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(np.array(start, dtype=float), step, options)
    best, best_cost, done = np.array(start, dtype=float), cost(np.asarray(start)), 1
    while not strategy.stop():
        points = strategy.ask()
        costs = [cost(point) for point in points]
        strategy.tell(points, costs)
        done += len(points)
        if min(costs) < best_cost:
            best, best_cost = np.array(points[int(np.argmin(costs))]), float(min(costs))
        if progress is not None:
            progress(min(done, evaluations), best_cost)
    return Optimum(best, best_cost, done)


def _cma() -> Any:
    try:
        import cma  # here, because it loads slowly
    except ImportError as error:
        raise InputError("the package cma is missing: python3 -m pip install 'flexros[design]'") from error
    return cma
