"""Initial values of the fit of a hypothesis."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.settings import FitSettings

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.prediction.predictor import Predictor

MOST = FitSettings().most_starts
"""Largest number of combinations unless another is given [1]."""


def initial_values(predictor: Predictor) -> FloatArray:
    """List initial values of a hypothesis.

    Args:
        predictor: Predictor of the hypothesis.

    Returns:
        Parameters in the units of the fit, tolerated deviations zero, shape (n_fitted, n_combinations).
    """
    values = starts_of(predictor.hypothesis)
    return np.vstack([values, np.zeros((predictor.tolerance.n_free, values.shape[1]))])


def starts_of(hypothesis: Hypothesis, most: int = MOST, *, of_one_size: bool = False) -> FloatArray:
    """List all combinations of the initial values of some candidates, or `most` of them, evenly spread.

    Args:
        hypothesis: The candidates.
        most: Largest number of combinations.
        of_one_size: As for `Candidate.starts`.

    Returns:
        Their parameters in the units of the fit, shape (n_effect, n_combinations).
    """
    combinations = [sum(parts, ()) for parts in product(*(one.starts(of_one_size=of_one_size) for one in hypothesis))]
    n_effect = sum(len(candidate.free) for candidate in hypothesis)
    grid = np.array(combinations, dtype=float).reshape(len(combinations), n_effect)
    kept = np.unique(np.linspace(0, len(grid) - 1, min(len(grid), most)).round().astype(int))
    starts: FloatArray = grid[kept].T
    return starts
