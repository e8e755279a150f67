"""The last stage of an identification: from a robust fit to the most accurate one."""

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
"""Most times that weights are made anew (chosen)."""

SETTLED = 1e-3
"""Change of all scaled parameters below which weights are not made anew (chosen)."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """A refined fit with the problem that it solves, whose weights belong to it.

    Attributes:
        problem: The problem with the weights of the last round.
        fit: The fit.
        rounds: How often weights were made.
        settled: Whether the last round changed no parameter any more, so that weights and fit belong to one another.
    """

    problem: GrayBoxProblem
    fit: GrayBoxFit
    rounds: int
    settled: bool


def refine(
    problem: GrayBoxProblem,
    found: GrayBoxFit,
    *,
    estimator: str = "LLS",
    weights: Weights | str = "combined",
    bounds: Mapping[str, tuple[float, float]] | None = None,
    settings: FitSettings | None = None,
) -> Refinement:
    """Fit again from what a robust fit has found, with weights from the fitted model and the measured covariance.

    User weights find the valley from far away, weights that know the noise use the data best at its bottom; the
    weights (8) of Moberg (2007, Paper A) need the true response, for which each round takes that of the fit before.

    Args:
        problem: What was fitted.
        found: The best fit so far.
        estimator: Estimator of the refined fit.
        weights: Its weights, or their kind.
        bounds: Bounds as for the fit before.
        settings: How to search.

    Returns:
        The refined fit.

    Raises:
        InputError: Optimal weights without a measured covariance.
    """
    chosen = problem.with_choice(estimator, weights)
    rounds, settled = 0, False
    while rounds < MOST_ROUNDS and not settled:
        rounds += 1
        chosen, before = chosen.reweighted(found.values), found
        found = fit(chosen, before.values, bounds, settings)
        change = problem.scale.scaled(found.values) - problem.scale.scaled(before.values)
        settled = bool(np.max(np.abs(change)) < SETTLED)
    return Refinement(chosen, found, rounds, settled)
