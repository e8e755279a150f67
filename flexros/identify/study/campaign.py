"""All fits of the study: the same starts for each of the six estimators."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import Fit, FitSettings, cost_at, fit
from flexros.identify.graybox.levenberg_marquardt import StopRule
from flexros.identify.graybox.multistart import best, multistart, random_starts
from flexros.identify.graybox.problem import GrayBoxProblem, graybox_problem
from flexros.identify.study.choices import REFERENCE, SIX
from flexros.identify.study.spread import estimated_spread

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from distributed import Client

    from flexros.arrays import FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class EstimatorRun:
    """What one estimator found.

    Attributes:
        fits: Fits in the order of the starts.
        user_cost: LLS cost of each fit over all positions with user weights; infinite without a rest, shape (S,).
        optimal_cost: The same with optimal weights, shape (S,).
    """

    fits: tuple[Fit, ...]
    user_cost: FloatArray
    optimal_cost: FloatArray

    @property
    def values(self) -> FloatArray:
        """Fitted values [SI], shape (S, P)."""
        return np.stack([each.values for each in self.fits])


@dataclass(frozen=True, eq=False)
class Study:
    """The study with everything its tables and pictures show.

    Attributes:
        problem: LLS with user weights over all positions, by whose cost all models are judged.
        runs: What each estimator found, by its name.
        best: Fit of lowest cost of the reference estimator.
        single: Number of the position that the estimator with one position took.
        theory: Standard deviation of the logarithms at `best` by (5) of the paper, with the correction, shape (P,).
        spread: Standard deviation of the logarithms of fits to responses drawn anew, see `spread`, shape (P,).
        redrawn: Number of fits behind `spread`.
        explanation: What the covariance says of the model.
    """

    problem: GrayBoxProblem
    runs: dict[str, EstimatorRun]
    best: Fit
    single: int
    theory: FloatArray
    spread: FloatArray
    redrawn: int
    explanation: str


def run_study(
    robot: Robot,
    responses: Sequence[FrequencyResponse],
    names: Sequence[str],
    *,
    starts: int = 100,
    seed: int = 1,
    redrawn: int = 100,
    threads: int | None = None,
    client: Client | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Study:
    """Fit from random starts within a factor of 10 with every estimator, and judge all models by the same cost.

    Args:
        robot: The nominal robot.
        responses: Measured responses, one per position.
        names: Names of the unknown parameters.
        starts: Number of random starts, the same for all estimators.
        seed: Seed of starts and redrawn noise.
        redrawn: Number of responses drawn anew for the empirical spread.
        threads: Threads of this process; default: one per processor.
        client: Dask client whose workers fit instead.
        progress: Called with the estimator's name, the number of fits done and the number there are.

    Returns:
        The study.
    """
    problem = graybox_problem(robot, responses, names)
    single = most_telling_position(problem)
    alone = graybox_problem(robot, [responses[single]], names)
    chosen = random_starts(problem, starts, seed)
    optimal = problem.with_choice("LLS", "optimal")
    runs: dict[str, EstimatorRun] = {}
    for kind in SIX:
        frame = problem if kind.all_positions else alone
        fits = multistart(
            frame.with_choice(kind.estimator, kind.weights),
            chosen,
            threads=threads,
            client=client,
            progress=_teller(progress, kind.name, starts),
        )
        costs = np.array([_costs(problem, optimal, each) for each in fits])
        runs[kind.name] = EstimatorRun(fits, costs[:, 0], costs[:, 1])
    found = best(runs[REFERENCE].fits)
    covariance = parameter_covariance(problem, found)
    return Study(
        problem=problem,
        runs=runs,
        best=found,
        single=single,
        theory=covariance.standard_deviation,
        spread=estimated_spread(problem, found, redrawn, seed),
        redrawn=redrawn,
        explanation=covariance.explanation,
    )


def most_telling_position(problem: GrayBoxProblem) -> int:
    """Find the position whose responses alone give the smallest covariance of all parameters, as the paper does.

    Args:
        problem: The problem over all positions; theory is evaluated at the robot's own values.

    Returns:
        Number of the position of smallest determinant.
    """
    nominal = fit(problem, settings=FitSettings(StopRule(iterations=0, evaluations=0), relinearisations=0))
    sizes = []
    for place, response in enumerate(problem.responses):
        frame = graybox_problem(problem.robot, [response], problem.names, problem.estimator.name, problem.setting)
        matrix = parameter_covariance(replace(frame, weights=problem.weights[place : place + 1]), nominal, False).matrix
        sizes.append(float(np.sum(np.log(np.maximum(np.linalg.eigvalsh(matrix), np.finfo(float).tiny)))))
    return int(np.argmin(sizes))


def _costs(user: GrayBoxProblem, optimal: GrayBoxProblem, found: Fit) -> tuple[float, float]:
    try:
        model = user.model_at(found.values)
    except InputError:  # springs too soft for the gravity of a position that was not fitted
        return np.inf, np.inf
    return cost_at(user, model, found.values), cost_at(optimal, model, found.values)


def _teller(progress: Callable[[str, int, int], None] | None, name: str, total: int) -> Callable[[int], None] | None:
    return None if progress is None else lambda done: progress(name, done, total)
