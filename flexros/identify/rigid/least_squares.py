"""Weighted least squares with standard deviations for correlated residuals (Moberg 2007, eq. 4.13)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import oaconvolve

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_MOST_ROUNDS = 20
"""Largest number of reweightings (chosen; few are needed)."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Values of a regression.

    Attributes:
        values: Parameters, shape (k,).
        deviation: Standard deviation of the residual of each motor, by which its rows were weighted, shape (M,).
        bread: Inverse of the normal matrix H' W H, shape (k, k).
        error: Norm of the residual of each motor [Nm or N], shape (M,).
    """

    values: FloatArray
    deviation: FloatArray
    bread: FloatArray
    error: FloatArray


def weighted_least_squares(H: FloatArray, y: FloatArray, n: int) -> Solution:
    """Solve tau = H pi, each motor weighted by its own residual.

    pi = (H' W H)^-1 H' W tau (eq. 4.13 with weights W). The solution with equal weights gives the weights of the next
    one, until the weights converge.

    Args:
        H: Regressor, shape (m, M, k), of full rank; the n rows of every motor or an orthogonal transformation of them.
        y: Torques [Nm or N], shape (m, M).
        n: Number of rows of each motor before the transformation.
    """
    rows, motors, k = H.shape
    deviation = np.ones(motors)
    freedom = max(n - k / motors, 1.0)
    size = np.sqrt(np.sum(y**2, axis=0) / n)
    size = np.where(size > 0, size, size.max())  # a motor whose torque is zero throughout can be fitted exactly
    tiny = np.finfo(float).eps * np.maximum(size, np.finfo(float).tiny)
    for _ in range(_MOST_ROUNDS):
        weighted = (H / deviation[:, None]).reshape(rows * motors, k)
        scale = np.linalg.norm(weighted, axis=0)
        orthogonal, upper = np.linalg.qr(weighted / scale)
        values = np.linalg.solve(upper, orthogonal.T @ (y / deviation).ravel()) / scale
        error = np.linalg.norm(y - H @ values, axis=0)
        used = deviation
        deviation = np.maximum(error / np.sqrt(freedom), tiny)
        if np.allclose(deviation, used, rtol=1e-3, atol=0.0):
            break
    inverse = np.linalg.inv(upper)
    return Solution(values, used, (inverse @ inverse.T) / np.outer(scale, scale), error)


def covariance(solution: Solution, moments: FloatArray, residual: FloatArray) -> FloatArray:
    """Covariance of the parameters for correlated residuals (W. K. Newey and K. D. West, 1987).

    Residuals are correlated over time wherever the model is incomplete; the usual formula would then be too optimistic.

    Args:
        solution: The solution.
        moments: Products of regressor and weighted residual, summed over the motors, shape (n, k).
        residual: Residual torque [Nm or N], shape (n, M).

    Returns:
        Shape (k, k).
    """
    n, motors = residual.shape
    k = len(solution.values)
    meat = long_run(moments, correlation_length(residual))
    result: FloatArray = solution.bread @ meat @ solution.bread * n / max(n - k / motors, 1.0)
    return result


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

    Twice the first lag at which the autocorrelation of every motor has vanished, at least the 4 (n / 100)^(2/9) of
    Newey and West (1994), at most a tenth of the record (chosen).

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


def long_run(moments: FloatArray, lags: int) -> FloatArray:
    """Sum the covariances of rows over all lags, with Bartlett weights.

    Args:
        moments: Shape (n, k).
        lags: Number of lags.

    Returns:
        Shape (k, k). The sum is a convolution, computed by Fourier transforms: long logs have thousands of lags.
    """
    weights = 1 - np.abs(np.arange(-lags, lags + 1)) / (lags + 1)
    smooth = oaconvolve(moments, weights[:, None], mode="full", axes=0)[lags : lags + len(moments)]
    total: FloatArray = moments.T @ smooth
    return (total + total.T) / 2
