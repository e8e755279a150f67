"""Search for the parameters: robust fits from several initial values, then an accurate fit from the best of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, argument_named
from flexros.identify.graybox.estimators import estimator_named
from flexros.identify.graybox.multistart import best, multistart, random_starts
from flexros.identify.graybox.parameter_scale import parameter_scale
from flexros.identify.graybox.problem import graybox_problem
from flexros.identify.graybox.refine import refine
from flexros.identify.graybox.weights import weights_named

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from distributed import Client

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.robot import Robot


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search for parameters.

    Attributes:
        estimator: "LLS", "LLSM" or "NLS".
        weights: Weights of the last fit, "user", "optimal" or "combined"; those from all starts have user weights,
            which find the valley from far away (Moberg 2007, Paper A, section 6). Those of the last fit are made with
            the fitted model's responses: chosen by the noisy ones, lines near the noise would bias logarithms.
        starts: Number of initial values; the first are the nominal values, the others are within a factor of ten of
            them, all within the bounds.
        seed: Seed of the initial values.
        bounds: Lower and upper bound of values [SI] by name; see `ParameterScale.bounds` for the others.
    """

    estimator: str = "LLS"
    weights: str = "combined"
    starts: int = 20
    seed: int = 1
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def check(self, robot: Robot, names: Sequence[str]) -> None:
        """Check the settings, so that impossible ones are refused before the measurement.

        Args:
            robot: The nominal robot.
            names: Unknown parameters.

        Raises:
            InputError: One of the settings is not possible.
        """
        with argument_named("estimator"):
            estimator_named(self.estimator)
        with argument_named("weights"):
            weights_named(self.weights)
        if self.starts < 1:
            raise InputError(f"{self.starts} starts were requested, but at least one is needed", "starts")
        if self.seed < 0:
            raise InputError(f"the seed is {self.seed}, but must be 0 or more", "seed")
        with argument_named("bound"):
            parameter_scale(robot, names).bounds(self.bounds)


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Outcome of a search.

    Attributes:
        problem: The problem with the weights of the last fit.
        fit: The last fit.
        searched: Fits from all initial values.
        settled: Whether the weights of the last fit belong to its values.
    """

    problem: GrayBoxProblem
    fit: GrayBoxFit
    searched: tuple[GrayBoxFit, ...]
    settled: bool = True

    @property
    def failed(self) -> int:
        """Number of starts at which the model could not be evaluated."""
        return sum(not np.isfinite(each.cost) for each in self.searched)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Limits of the search, one sentence each."""
        texts = []
        if self.failed:
            texts.append(
                f"{self.failed} of {len(self.searched)} starts failed, because the model cannot be evaluated there."
            )
        if not self.settled:
            texts.append(
                "The weights of the last fit did not settle: each fit with weights made anew changed the parameters "
                "again. Try other weights."
            )
        return tuple(texts)


def search(
    robot: Robot,
    responses: Sequence[FrequencyResponse],
    names: Sequence[str],
    settings: SearchSettings,
    client: Client | None = None,
    progress: Callable[[int], None] | None = None,
) -> SearchResult:
    """Fit from several initial values, then refine the best fit with the requested weights.

    Args:
        robot: The robot with its nominal values.
        responses: Measured responses, one per position.
        names: Names of the unknown parameters.
        settings: Settings of the search.
        client: Dask client whose workers fit instead of threads of this process.
        progress: Called with the number of fits done.

    Returns:
        The outcome.

    Raises:
        InputError: Estimator, weights, names, bounds or responses are not possible.
        RunError: The model cannot be evaluated at any start.
    """
    settings.check(robot, names)
    problem = graybox_problem(robot, responses, names, settings.estimator, "user")
    problem.with_choice(settings.estimator, settings.weights)  # refuses impossible choices before the search
    scale, bounds = problem.scale, settings.bounds
    starts = np.clip(scale.nominal, *map(scale.values, scale.bounds(bounds)))[None]
    if settings.starts > 1:
        starts = np.vstack([starts, random_starts(problem, settings.starts - 1, settings.seed, bounds=bounds)])
    searched = multistart(problem, starts, bounds=bounds, client=client, progress=progress)
    refined = refine(problem, best(searched), estimator=settings.estimator, weights=settings.weights, bounds=bounds)
    return SearchResult(refined.problem, refined.fit, searched, refined.settled)
