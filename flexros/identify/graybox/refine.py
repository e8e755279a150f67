"""Refinement of a robust fit with weights from the fitted model and the measured covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.fit import FitSettings, GrayBoxFit, fit

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.identify.graybox.weights import Weights

MOST_ROUNDS = 4
"""Largest number of times that the weights are computed again (chosen)."""

SETTLED = 1e-3
"""Change of all scaled parameters below which the weights are not computed again (chosen)."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """A refined fit and its problem with the final weights.

    Attributes:
        problem: The problem with the weights of the last round.
        fit: The fit.
        rounds: Number of times that the weights were computed.
        settled: Whether the last round changed no parameter, so that weights and fit are consistent.
    """

    problem: GrayBoxProblem
    fit: GrayBoxFit
    rounds: int
    settled: bool


def refine(
    problem: GrayBoxProblem,
    robust: GrayBoxFit,
    *,
    estimator: str = "LLS",
    weights: Weights | str = "combined",
    bounds: Mapping[str, tuple[float, float]] | None = None,
    settings: FitSettings | None = None,
) -> Refinement:
    """Refit from a robust fit, with weights from the fitted model and the measured covariance.

    User weights find the right minimum from far away; weights that know the noise use the data best near it. The
    weights (8) of Moberg (2007, Paper A) need the true response, which each round approximates by the previous fit.

    Args:
        problem: Problem of the robust fit.
        robust: The robust fit.
        estimator: Estimator of the refined fit.
        weights: Its weights, or their kind.
        bounds: Bounds, as for the robust fit.
        settings: Search settings.

    Raises:
        InputError: Optimal weights without a measured covariance.
    """
    refined = problem.with_choice(estimator, weights)
    current = robust
    rounds, settled = 0, False
    while rounds < MOST_ROUNDS and not settled:
        rounds += 1
        refined, before = refined.reweighted(current.values), current
        current = fit(refined, before.values, bounds, settings)
        change = problem.scale.scaled(current.values) - problem.scale.scaled(before.values)
        settled = bool(np.max(np.abs(change)) < SETTLED)
    return Refinement(refined, current, rounds, settled)
