"""The most informative further experiment for a combination of parameters that the data do not determine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True)
class NextExperiment:
    """The best single further experiment for a combination of parameters.

    Attributes:
        candidate: Number of the candidate position, 0-based.
        before: Standard deviation of the combination now [1].
        after: The same with the further experiment [1].
    """

    candidate: int
    before: float
    after: float


def next_experiment(total: FloatArray, information: FloatArray, direction: FloatArray) -> NextExperiment:
    """Find the candidate that makes the variance of a combination of parameters smallest.

    Args:
        total: Information so far, logarithmic parameters, regular, shape (P, P).
        information: Information of one further experiment in each candidate, shape (Q, P, P).
        direction: The combination v, of which v^T theta is wanted, shape (P,).

    Returns:
        The experiment.
    """
    before = float(direction @ np.linalg.solve(total, direction))
    size = np.sqrt(np.diag(total))
    scaled = (total + information) / np.outer(size, size)
    target = direction / size
    after = (
        np.linalg.solve(scaled, np.broadcast_to(target, (len(information), len(target)))[..., None])[..., 0] @ target
    )
    best = int(np.argmin(after))
    return NextExperiment(best, float(np.sqrt(before)), float(np.sqrt(after[best])))


def most_telling_frequency(by_frequency: FloatArray, total: FloatArray, direction: FloatArray) -> int:
    """Find the frequency whose information makes the variance of a combination fall fastest.

    Args:
        by_frequency: Information at each frequency, shape (F, P, P).
        total: All information, shape (P, P).
        direction: The combination, shape (P,).

    Returns:
        Index of the frequency: largest w^T I_k w with w = total^-1 direction, the derivative of the variance.
    """
    weighed = np.linalg.solve(total, direction)
    return int(np.argmax(weighed @ by_frequency @ weighed))
