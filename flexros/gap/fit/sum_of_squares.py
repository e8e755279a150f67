"""Sums of squares of the weighted prediction errors of a hypothesis, with the prior of its tolerated deviations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.prediction.compiled_plant import in_lanes

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData


def chi2_of(predictor: Predictor, data: FitData, thetas: FloatArray) -> FloatArray:
    """Evaluate the sum of squares for many sets of parameters.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        thetas: Parameters in the units of the fit, shape (n_fitted, sets).

    Returns:
        Sums of squares, infinite where the prediction diverges, shape (sets,).
    """
    sums: FloatArray = np.concatenate(
        [sums_of(predictor, data, data.residuals(predictor, group), group) for group in in_lanes(thetas)]
    )
    return sums


def sums_of(predictor: Predictor, data: FitData, residuals: FloatArray, thetas: FloatArray) -> FloatArray:
    """Add up the squares of prediction errors that are known, and the prior.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        residuals: Weighted prediction errors, shape (n_values, lanes).
        thetas: Parameters in the units of the fit, shape (n_fitted, sets).

    Returns:
        As for `chi2_of`, shape (sets,).
    """
    sums = np.einsum("ij,ij->j", residuals, residuals)[: thetas.shape[1]]
    sums = sums + data.misfit * np.sum(thetas[predictor.n_effect :] ** 2, axis=0)
    return np.where(np.isfinite(sums), sums, np.inf)
