"""Significance of an excess over all locations tested, and its concentration in a location."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def p_values(measured: FloatArray, null: FloatArray) -> FloatArray:
    """Compute p-values with the maximum statistic, which corrects for many tests (Westfall & Young 1993).

    The statistics of each location are standardised over the log and all logs without a gap together. Without a gap the
    log is exchangeable with them, so that the p-values are exact for any distribution.

    Args:
        measured: Statistic of each location, shape (P,); larger where there is more excess.
        null: The same of N simulated logs without a gap, shape (N, P).

    Returns:
        Probability that the largest statistic of all locations is as large without a gap [1], shape (P,).
    """
    if not len(measured):
        return np.zeros(0)
    both = np.vstack([measured[None], null])
    spread = both.std(axis=0)
    scored = (both - both.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    largest = scored[1:].max(axis=1)
    above = (largest[:, None] >= scored[0]).sum(axis=0)
    return np.asarray((1 + above) / (1 + len(null)))


def concentration(share: FloatArray, expected: FloatArray) -> FloatArray:
    """Compute the concentration of the excess in locations against evenly spread excess (Kulldorff 1997).

    Args:
        share: Share of the excess in each location [1], shape (P,).
        expected: Share of evenly spread excess there [1], shape (P,).

    Returns:
        Log-likelihood ratio per unit of excess [nats], zero where there is less than expected, shape (P,).
    """
    share = np.clip(share, 0.0, 1.0)
    expected = np.clip(expected, 1e-12, 1 - 1e-12)
    rest = 1 - share
    score = share * np.log(np.maximum(share, 1e-300) / expected)
    score = score + np.where(rest > 0, rest * np.log(np.maximum(rest, 1e-300) / (1 - expected)), 0.0)
    return np.where(share > expected, score, 0.0)
