"""Colour of noise: autoregression of stretches after removal of a trend, and its spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

MOST_ORDER = 4
"""Largest order of the autoregression (chosen)."""
WHITE = 3.5
"""Autocorrelation at lags one to four, in standard deviations, from which noise is coloured (chosen)."""
TREND = 3
"""Number of polynomial coefficients removed from each stretch of a standstill (chosen)."""
GRID = 512
"""Frequencies from zero to the Nyquist frequency at which a spectrum is stored (chosen)."""
PASSES = 8
"""Iterations of the autoregression, each corrected for the power that the trend removed (chosen)."""


def without_trend(values: FloatArray) -> FloatArray:
    """Subtract the best parabola from a stretch.

    Args:
        values: The stretch [any], shape (L,).
    """
    time = np.linspace(-1.0, 1.0, len(values))
    return np.asarray(
        values - np.polynomial.polynomial.polyval(time, np.polynomial.polynomial.polyfit(time, values, TREND - 1))
    )


def colour_of(noise: FloatArray) -> tuple[float, float, FloatArray]:
    """Fit an autoregression e_k = sum a_j e_(k-j) + w_k.

    Removing the trend of each stretch removes noise of the lowest frequencies, which is corrected for: with p
    coefficients in L samples, p / L of the sum of all autocovariances, at every lag.

    Args:
        noise: Stretches without their trend [any], shape (n, L).

    Returns:
        The information criterion of Schwarz (1978), the standard deviation of the noise, and the coefficients, none for
        white noise, shape (p,).
    """
    count, length = noise.shape
    lags = np.array([np.mean(noise[:, lag:] * noise[:, : length - lag]) for lag in range(MOST_ORDER + 1)])
    white = lags[0] / (1 - TREND / length)
    limit = WHITE / np.sqrt(count * length) + TREND / length  # a removed trend leaves a small correlation
    if np.all(np.abs(lags[1:]) <= limit * lags[0]):
        return noise.size * float(np.log(max(white, 1e-300))), float(np.sqrt(white)), np.zeros(0)
    cost, removed, coefficients = np.inf, 0.0, np.zeros(0)
    for _ in range(PASSES):
        cost, coefficients, driving = _autoregression(lags + removed, noise.size)
        removed = min(TREND / length * max(driving, 0.0) / max(1 - coefficients.sum(), 1e-3) ** 2, lags[0])
    return cost, float(np.sqrt(lags[0] + removed)), coefficients


def _autoregression(lags: FloatArray, n_samples: int) -> tuple[float, FloatArray, float]:
    """Fit an autoregression of the best order; return information criterion, coefficients and driving variance."""
    best, driving = np.inf, float(lags[0])
    coefficients: FloatArray = np.zeros(0)
    for order in range(1, MOST_ORDER + 1):
        matrix = lags[np.abs(np.subtract.outer(np.arange(order), np.arange(order)))]
        values = np.linalg.solve(matrix, lags[1 : order + 1])
        variance = lags[0] - values @ lags[1 : order + 1]
        cost = n_samples * np.log(max(variance, 1e-300)) + order * np.log(n_samples)
        if cost < best:
            best, coefficients, driving = cost, np.asarray(values, dtype=np.float64), float(variance)
    return float(best), coefficients, driving


def white_spectrum(n_motors: int) -> FloatArray:
    """Return the spectrum of white noise from zero to the Nyquist frequency, shape (`GRID`, M)."""
    return np.ones((GRID, n_motors))


def autoregressive_spectrum(coefficients: FloatArray) -> FloatArray:
    """Compute the spectrum of e_k = a_1 e_k-1 + ... + a_p e_k-p + white noise.

    Args:
        coefficients: a_1 ... a_p of each motor, shape (p, M).

    Returns:
        Power density from zero to the Nyquist frequency, of mean one, shape (`GRID`, M).
    """
    angle = np.pi * (np.arange(GRID) + 0.5) / GRID
    delays = np.exp(-1j * angle[:, None] * (1 + np.arange(len(coefficients))))
    power = 1 / np.abs(1 - delays @ coefficients) ** 2
    return np.asarray(power / power.mean(axis=0))
