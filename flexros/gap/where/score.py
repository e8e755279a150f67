"""How significant an excess is, over all places looked at, and how much it is concentrated in a place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def p_values(found: FloatArray, null: FloatArray) -> FloatArray:
    """Compute p-values with the maximum statistic, so that many looks raise no alarm (Westfall & Young 1993).

    The statistics of each place are standardised over the log and all logs without gap together; without gap the log is
    one of them like any other, so that the p-values hold exactly, whatever the distributions are.

    Args:
        found: Statistic of each place, shape (P,); larger where there is more excess.
        null: The same of N simulated logs without gap, shape (N, P).

    Returns:
        Probability that the largest statistic of all places is as large without a gap [1], shape (P,).
    """
    if not len(found):
        return np.zeros(0)
    every = np.vstack([found[None], null])
    spread = every.std(axis=0)
    scored = (every - every.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    largest = scored[1:].max(axis=1)
    above = (largest[:, None] >= scored[0]).sum(axis=0)
    return np.asarray((1 + above) / (1 + len(null)))


def concentration(share: FloatArray, expected: FloatArray) -> FloatArray:
    """Score how much more of the excess lies in places than evenly spread excess would put there (Kulldorff 1997).

    Args:
        share: Share of the excess in each place [1], shape (P,).
        expected: Share that an even spread puts there [1], shape (P,).

    Returns:
        Log-likelihood ratio per unit of excess [nats], zero where less lies there than expected, shape (P,).
    """
    share = np.clip(share, 0.0, 1.0)
    expected = np.clip(expected, 1e-12, 1 - 1e-12)
    rest = 1 - share
    score = share * np.log(np.maximum(share, 1e-300) / expected)
    score = score + np.where(rest > 0, rest * np.log(np.maximum(rest, 1e-300) / (1 - expected)), 0.0)
    return np.where(share > expected, score, 0.0)
