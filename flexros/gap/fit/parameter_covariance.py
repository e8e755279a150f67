"""Covariance of fitted numbers when the prediction errors are not quite white."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import uniform_filter1d

from flexros.gap.fit.least_squares import linearise

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData

FEWEST_LINES = 12
"""Lines of a periodogram that are averaged at least, half of them to each side [1] (chosen)."""
BANDS = 12
"""Bands of frequencies, each up to twice that of the last, that have windows of their own [1] (chosen)."""


def parameter_covariance(one: CandidateFit, data: FitData) -> FloatArray:
    """Compute the covariance of the numbers of a fit (White 1980, Huber 1967: the sandwich).

    The predictor of constant gain whitens neither noise nor what a model leaves: prediction errors r have a spectrum S,
    low where it tracks noise, high where something is left. With the derivatives J of the errors and their transforms
    J(f),

        cov = H^-1 (sum_f J(f)^* S(f) J(f) / n + P) H^-1,    H = J'J + P,

    with the prior P of tolerated numbers. With S = 1 this is H^-1.

    Args:
        one: The fit, at its minimum.
        data: The log that it was fitted to.

    Returns:
        Covariance of the numbers that the fit moves, shape (n_fitted, n_fitted).
    """
    line = linearise(one.predictor, data, one.theta)
    J, r = line.slopes, line.residual
    meat = line.information - J.T @ J  # the prior
    n, M = data.spread.shape
    for motor in range(M):
        rows = slice(motor * n, (motor + 1) * n)
        transform = np.fft.rfft(J[rows], axis=0)
        spectrum = smoothed(np.abs(np.fft.rfft(r[rows])) ** 2) / max(int(np.isfinite(data.spread[:, motor]).sum()), 1)
        weight = np.full(len(spectrum), 2.0)
        weight[0] = 1.0
        weight[-1] = 1.0 if n % 2 == 0 else 2.0
        meat += np.real(np.conj(transform).T @ (transform * (weight * spectrum)[:, None])) / n
    meat += J[M * n :].T @ J[M * n :]
    inverse = np.linalg.pinv(line.information)
    covariance: FloatArray = inverse @ meat @ inverse
    return covariance


def smoothed(periodogram: FloatArray) -> FloatArray:
    """Average a periodogram over windows that grow with the frequency.

    Args:
        periodogram: Power of each line from zero frequency on, shape (n,).

    Returns:
        The average around each line, shape (n,).
    """
    result = np.array(periodogram, dtype=float)
    begin, width = 0, FEWEST_LINES
    for _ in range(BANDS):
        end = min(len(periodogram), 4 * width)
        around = uniform_filter1d(periodogram, min(width, len(periodogram)), mode="reflect")
        result[begin:end] = around[begin:end]
        if end == len(periodogram):
            break
        begin, width = end, 2 * width
    else:
        result[begin:] = uniform_filter1d(periodogram, width, mode="reflect")[begin:]
    return result
