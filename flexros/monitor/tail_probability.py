"""Tail probability of the mean square of noise: a weighted sum of squares of normal variables.

P(sum_i w_i z_i^2 > x) by the saddlepoint formula of Lugannani and Rice (1980), which is accurate to a few per cent far
out in the tail, beyond the reach of simulation (Kuonen 1999).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import brentq
from scipy.special import log_ndtr

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

EXACT = 256
"""Most samples for an eigenvalue decomposition of the covariance matrix (chosen)."""
FEWER = 2048
"""Number of weights of longer windows (chosen)."""


def weights_of_mean_square(autocovariance: FloatArray, samples: int) -> tuple[FloatArray, float]:
    """Write the mean square of a stationary normal signal as a weighted sum of squares of independent variables.

    Args:
        autocovariance: Autocovariance at lags 0, 1, ..., over that at lag 0; zero beyond, shape (lags,).
        samples: Samples n of the window.

    Returns:
        Weights, shape (k,), and the multiplicity of each; the sum over all is one.
    """
    r = np.zeros(max(samples, 2))
    known = min(len(autocovariance), samples)
    r[:known] = autocovariance[:known]
    if samples <= EXACT:
        weights = np.clip(np.linalg.eigvalsh(toeplitz(r[:samples])), 0.0, None)
        return weights / weights.sum(), 1.0
    # long windows: the eigenvalues are the spectrum
    spectrum = np.fft.rfft(np.concatenate([r[: samples // 2], r[1 : samples // 2][::-1]])).real
    line = (np.arange(min(FEWER, samples)) + 0.5) / min(FEWER, samples) * (len(spectrum) - 1)
    weights = np.clip(np.interp(line, np.arange(len(spectrum)), spectrum), 0.0, None)
    times = samples / len(weights)
    return weights / (weights.sum() * times), times


def log_tail(weights: FloatArray, times: float, level: float) -> float:
    """Compute ln P(sum_i w_i z_i^2 > level) for a level above the mean, which is one.

    Args:
        weights: Weights w, shape (k,).
        times: Multiplicity of each weight.
        level: The level [1].

    Returns:
        Logarithm of the probability.
    """
    highest = 1 / (2 * float(weights.max()))

    def slope(s: float) -> float:
        return times * float(np.sum(weights / (1 - 2 * s * weights))) - level

    s = brentq(slope, 0.0, highest * (1 - 1e-12), xtol=1e-14 * highest)
    K = -times / 2 * float(np.sum(np.log1p(-2 * s * weights)))
    curvature = 2 * times * float(np.sum((weights / (1 - 2 * s * weights)) ** 2))
    w, u = np.sqrt(max(2 * (s * level - K), 1e-300)), s * np.sqrt(curvature)
    if w < 1e-4:
        return float(np.log(0.5))
    return float(log_ndtr(-w - np.log(u / w) / w))


def threshold(weights: FloatArray, times: float, probability: float) -> float:
    """Find the level that is exceeded with a probability.

    Args:
        weights: Weights, shape (k,).
        times: Multiplicity of each weight.
        probability: The probability, below a tenth.

    Returns:
        The level, over the mean [1].
    """
    wanted, high = float(np.log(probability)), 2.0
    while log_tail(weights, times, high) > wanted:
        high *= 1.5
    return float(brentq(lambda level: log_tail(weights, times, level) - wanted, 1.0 + 1e-4, high, xtol=1e-9))
