"""What a change of a number of the robot takes over from tolerated deviations that were strained to stand for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.model_change import AbstractChangedValues

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.least_squares import CandidateFit


@dataclass(frozen=True, eq=False)
class Relief:
    """A candidate in place of tolerated deviations.

    Attributes:
        price: Sum of the squared deviations that it takes over, in standard deviations [1].
        start: Numbers of the candidate that do the same, as the fit moves them, shape (n_free,).
        theta: Numbers of the fit without these deviations, shape (n_fitted,).
    """

    price: float
    start: FloatArray
    theta: FloatArray


def relief(candidate: Candidate, found: CandidateFit) -> Relief | None:
    """Put a candidate in place of the tolerated deviations of the same numbers.

    The candidate and these deviations do the same to the robot, so that the data do not tell them apart: all that the
    candidate gains is the price of the deviations. Directions taken at another point are not equal enough to show it.

    Args:
        candidate: An effect at a place.
        found: A fit without it.

    Returns:
        What it takes over; None where it is no common factor on tolerated numbers.
    """
    predictor = found.predictor
    if not issubclass(candidate.effect, AbstractChangedValues) or len(candidate.free) != 1:
        return None
    effect = candidate.typical().effect
    assert isinstance(effect, AbstractChangedValues)
    changed = effect.values(predictor.robot, candidate.location).keys()
    mine = np.array([name in changed for name in predictor.tolerance.names], dtype=bool)
    if not mine.any():
        return None
    n = predictor.n_effect
    factor = float(np.exp(np.mean((np.array(predictor.tolerance.deviations) * found.theta[n:])[mine])))
    (free,) = candidate.free
    theta = found.theta.copy()
    theta[n:][mine] = 0.0
    return Relief(float(np.sum(found.theta[n:][mine] ** 2)), np.array([free.encode(factor - 1)]), theta)


def with_relief(
    candidate: Candidate, first: CandidateFit, promise: float, start: FloatArray
) -> tuple[float, FloatArray]:
    """Say what a candidate promises beside a fit and where to start: in place of tolerated deviations if that is more.

    Args:
        candidate: An effect at a place.
        first: A fit without it.
        promise: Fall of the sum of squares that linear theory promises.
        start: Numbers of the candidate that go with this promise, as the fit moves them, shape (n_free,).

    Returns:
        The promise, and numbers of both together, shape (n_fitted,).
    """
    theta, eased = first.theta, relief(candidate, first)
    if eased is not None and eased.price > promise:
        promise, start, theta = eased.price, eased.start, eased.theta
    n = first.predictor.n_effect
    return promise, np.concatenate([theta[:n], start, theta[n:]])
