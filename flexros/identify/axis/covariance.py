"""Covariance of a least-squares estimate whose errors may be correlated in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.covariance import NULL

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_TAKES_PART = 1e-3
"""Component of a null direction from which a parameter takes part in it (chosen above rounding errors)."""


def prediction_covariance(errors: FloatArray, slopes: FloatArray, lags: int) -> FloatArray:
    """Compute the covariance of a least-squares estimate whose errors may be correlated over some samples.

    Gauss-Newton covariance for white errors; deviations for which the sandwich of W. Newey and K. West (1987, Bartlett
    weights) is larger are raised to it. That sandwich is itself an estimate, less accurate with more lags relative to
    the length of the record: its deviations are multiplied by the 97.5 % quantile of N. M. Kiefer and T. J. Vogelsang
    (2005, Econometric Theory 21, table 1) over that of the normal distribution. Parameters that are part of a direction
    which the record does not determine have an infinite variance.

    Args:
        errors: Prediction errors, shape (n,).
        slopes: Their derivatives with respect to the parameters, shape (n, P).
        lags: Number of samples over which errors may be correlated.

    Returns:
        Covariance, shape (P, P).
    """
    size = np.sqrt(np.sum(slopes**2, axis=0))
    size = np.where(size > 1e-12 * np.max(size), size, np.inf)
    scaled = slopes / size
    scores = scaled * errors[:, None]
    middle = scores.T @ scores
    lags = min(lags, len(errors) // 10)
    for lag in range(1, lags + 1):
        product = scores[lag:].T @ scores[:-lag]
        middle += (1 - lag / (lags + 1)) * (product + product.T)
    eigenvalues, vectors = np.linalg.eigh(scaled.T @ scaled)
    seen = eigenvalues > NULL * eigenvalues[-1]
    inverse = (vectors[:, seen] / eigenvalues[seen]) @ vectors[:, seen].T
    identifiable = np.all(np.abs(vectors[:, ~seen]) < _TAKES_PART, axis=1)
    white = inverse * float(errors @ errors) / (len(errors) - np.count_nonzero(seen))
    sandwich = np.diag(inverse @ middle @ inverse) * (_quantile((lags + 1) / len(errors)) / _quantile(0.0)) ** 2
    variance = np.where(identifiable, np.diag(white), 1.0)
    raised = np.where(identifiable, np.sqrt(np.maximum(sandwich / variance, 1.0)), 1.0) / size
    covariance: FloatArray = raised[:, None] * white * raised
    covariance[~identifiable, ~identifiable] = np.inf
    return covariance


def _quantile(share: float) -> float:
    """97.5 % quantile of an estimate over its Bartlett deviation; `share` is lags over samples."""
    return float(np.polyval([-0.5324, 0.4160, 2.9694, 1.9600], share))
