"""Weighted least squares with standard deviations that allow for correlated residuals (Moberg 2007, eq. 4.13)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_MOST_ROUNDS = 20
"""Largest number of times that the weights are renewed (chosen; few are needed)."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Result of a regression.

    Attributes:
        values: Parameters, shape (k,).
        covariance: Their covariance, shape (k, k).
        residual: Torque that is left [Nm or N], shape (n, M).
        deviation: Standard deviation of the residual of each motor, by which its rows were weighted, shape (M,).
    """

    values: FloatArray
    covariance: FloatArray
    residual: FloatArray
    deviation: FloatArray


def weighted_least_squares(H: FloatArray, y: FloatArray) -> Estimate:
    """Solve tau = H pi, each motor weighted by its own residual.

    pi = (H' W H)^-1 H' W tau (eq. 4.13 with weights W). The first solution, with equal weights, gives the weights of
    the second, and so on until they stay. The covariance is that of W. K. Newey and K. D. West (1987): residuals are
    correlated over time wherever the model is not complete, and the usual formula would then promise too much.

    Args:
        H: Regressor, shape (n, M, k), of full rank.
        y: Torques [Nm or N], shape (n, M).

    Returns:
        The estimate.
    """
    n, motors, k = H.shape
    deviation = np.ones(motors)
    tiny = np.finfo(float).eps * np.maximum(np.sqrt(np.mean(y**2, axis=0)), np.finfo(float).tiny)
    for _ in range(_MOST_ROUNDS):
        weighted = (H / deviation[:, None]).reshape(n * motors, k)
        scale = np.linalg.norm(weighted, axis=0)
        orthogonal, upper = np.linalg.qr(weighted / scale)
        values = np.linalg.solve(upper, orthogonal.T @ (y / deviation).ravel()) / scale
        residual = y - H @ values
        used = deviation
        deviation = np.maximum(np.sqrt(np.sum(residual**2, axis=0) / max(n - k / motors, 1.0)), tiny)
        if np.allclose(deviation, used, rtol=1e-3, atol=0.0):
            break
    inverse = np.linalg.inv(upper)
    bread = (inverse @ inverse.T) / np.outer(scale, scale)
    moments = np.einsum("nmk,nm->nk", H, residual / used**2)
    covariance = bread @ _long_run(moments, correlation_length(residual)) @ bread * n / max(n - k / motors, 1.0)
    return Estimate(values, covariance, residual, used)


def condition_number(H: FloatArray, deviation: FloatArray) -> float:
    """Condition number of a regressor whose columns are scaled to the same size.

    Args:
        H: Regressor, shape (n, M, k).
        deviation: Standard deviation of each motor's residual, shape (M,).

    Returns:
        Largest over smallest singular value.
    """
    weighted = (H / deviation[:, None]).reshape(-1, H.shape[2])
    return float(np.linalg.cond(weighted / np.linalg.norm(weighted, axis=0)))


def correlation_length(residual: FloatArray) -> int:
    """Number of samples over which residuals are correlated.

    Twice the first lag at which the autocorrelation of any motor is gone, at least the 4 (n / 100)^(2/9) of Newey and
    West (1994), at most a tenth of the record (chosen).

    Args:
        residual: Shape (n, M).

    Returns:
        Number of lags.
    """
    n = len(residual)
    longest = 0
    for column in residual.T:
        spectrum = np.fft.rfft(column - column.mean(), 2 * n)
        correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:n]
        gone = np.flatnonzero(correlation <= 0)
        longest = max(longest, int(gone[0]) if gone.size else n)
    return min(max(2 * longest, int(4 * (n / 100) ** (2 / 9))), n // 10)


def _long_run(moments: FloatArray, lags: int) -> FloatArray:
    """Sum of the covariances of rows over all lags, those of longer lags with less weight; shape (k, k)."""
    total = moments.T @ moments
    for lag in range(1, lags + 1):
        part = moments[lag:].T @ moments[:-lag]
        total = total + (1 - lag / (lags + 1)) * (part + part.T)
    return total
