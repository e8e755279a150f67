"""Parts of a log: the parameters of a fit by each part alone, and how much they vary more than by chance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.residuals.fit_data import FitData

RIDGE = 1e-6
"""Share of its information that is added to every parameter, for those that a part does not determine [1]."""


def parts_of(data: FitData, number: int) -> IntArray:
    """Divide the prediction errors of the motors into parts with equally many samples that count.

    Args:
        data: The log.
        number: Parts [1].

    Returns:
        Part of each error, motor after motor, shape (M n_samples,).
    """
    counted = np.cumsum(np.isfinite(data.spread).any(axis=1))
    return np.tile(np.maximum(counted - 1, 0) * number // max(int(counted[-1]), 1), data.spread.shape[1])


def estimates_of_parts(
    slopes: FloatArray, residual: FloatArray, part: IntArray, prior: FloatArray, pulled: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Estimate the parameters of a linearised fit from each part of its residuals.

    With the part k of residuals r and slopes J, and a K-th of the prior P around zero,

        d_k = -(J_k'J_k + P/K)^-1 (J_k'r_k + P theta/K)

    Args:
        slopes: Derivatives J of the residuals to the parameters, shape (n, p).
        residual: The residuals r, shape (n,).
        part: Part of each residual, 0 to K - 1, shape (n,).
        prior: Information P of the prior on each parameter, shape (p,).
        pulled: P theta, shape (p,).

    Returns:
        Differences from the parameters of the whole, and their standard deviations by the residuals of the part,
        shape (K, p) each.
    """
    K = int(part.max()) + 1
    free = prior + RIDGE * np.einsum("ij,ij->j", slopes, slopes) + 1e-300
    estimates, deviations = np.empty((2, K, slopes.shape[1]))
    for k in range(K):
        J, r = slopes[part == k], residual[part == k]
        covariance = np.linalg.pinv(J.T @ J + np.diag(free) / K, hermitian=True)
        estimates[k] = -covariance @ (J.T @ r + pulled / K)
        deviations[k] = np.sqrt(np.mean(r**2) * np.diag(covariance)) if r.any() else np.inf
    return estimates, deviations


def variation_between_parts(estimates: FloatArray, deviations: FloatArray) -> FloatArray:
    """Estimate by how much parameters differ from part to part beyond chance (DerSimonian and Laird 1986).

    With the weights w_k = 1 / s_k^2 of K estimates d_k and their weighted mean m,

        tau^2 = (sum w_k (d_k - m)^2 - (K - 1)) / (sum w_k - sum w_k^2 / sum w_k), or 0 where that is negative.

    Args:
        estimates: Parameters d by each part, shape (K, p).
        deviations: Their standard deviations s, shape (K, p).

    Returns:
        Standard deviations tau, shape (p,).
    """
    weights = 1.0 / np.maximum(deviations, 1e-150) ** 2
    total = weights.sum(axis=0)
    squares = np.sum(weights * (estimates - np.sum(weights * estimates, axis=0) / total) ** 2, axis=0)
    excess = (squares - (len(estimates) - 1)) / np.maximum(total - np.sum(weights**2, axis=0) / total, 1e-300)
    return np.asarray(np.sqrt(np.maximum(excess, 0.0)))
