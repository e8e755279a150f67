"""Candidates that may be added to a fit, with what linear theory says of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.tolerance_takeover import with_takeover

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.directions import Directions
    from flexros.gap.fit.screening import Surroundings

SMALLEST = 1e-12
"""Size over an initial one below which an effect does nothing [1]."""


@dataclass(frozen=True, eq=False)
class Addition:
    """A candidate that may be added to a fit.

    Attributes:
        candidate: The candidate.
        gain: Fall of the sum of squares that linear theory predicts [1].
        start: Its initial value, in the units of the fit, shape (n_free,).
        replaced: Whether the candidate takes over the deviation of a tolerated parameter, shape (n_names,).
        change: Change of the prediction errors by the initial value, on the rows of the search, shape (n_rows,).
    """

    candidate: Candidate
    gain: float
    start: FloatArray
    replaced: BoolArray
    change: NDArray[np.float32]

    def sized(self, size: float) -> Addition:
        """Return the same with its sizes scaled; one that linear theory turns around begins where it does nothing.

        A candidate in place of a tolerated number keeps its initial value, and so do parameters that shape it.

        Args:
            size: Size over the initial one, positive or negative [1].
        """
        if self.replaced.any():
            return self
        start = self.start.copy()
        for index, free in enumerate(self.candidate.free):
            low, high = free.bounds
            if self.candidate.neutral(free) not in (None, high):
                scaled = start[index] * size if free.signed else start[index] + np.log(max(size, SMALLEST))
                start[index] = np.clip(scaled, low, high)
        return replace(self, start=start)


def begun_at(candidate: Candidate, values: Mapping[str, float], fit: CandidateFit, n_rows: int) -> Addition:
    """Prepare the addition of a candidate that begins with given values; linear theory says nothing of it.

    Args:
        candidate: The candidate.
        values: Values of its free parameters by name [their units].
        fit: The fit that it is added to.
        n_rows: Number of rows of the search.
    """
    start = np.array([free.encode(values[free.name]) for free in candidate.free])
    replaced = np.zeros(len(fit.predictor.tolerance.names), dtype=bool)
    return Addition(candidate, 0.0, start, replaced, np.zeros(n_rows, dtype=np.float32))


def best_starts(direction: Directions, surroundings: Surroundings, most: int = 2) -> IntArray:
    """Return the indices of the initial values that lower the sum of squares most, without scaling."""
    return _best_first(direction, surroundings.gains(direction.changes)[1])[:most]


def addition_of(direction: Directions, fit: CandidateFit, surroundings: Surroundings) -> Addition:
    """Prepare the addition of a candidate to a fit, in place of tolerated deviations where that gains more."""
    gains, unscaled = surroundings.gains(direction.changes)
    best, gain = int(_best_first(direction, unscaled)[0]), float(gains.max())
    misfit = float(surroundings.prior.max(initial=1.0))
    takeover = with_takeover(direction.candidate, fit, gain, direction.starts[:, best], misfit)
    return Addition(direction.candidate, takeover.gain, takeover.start, takeover.replaced, direction.changes[:, best])


def _best_first(direction: Directions, lowered: FloatArray) -> IntArray:
    """Sort the initial values that can be used by how much they lower the sum of squares."""
    return np.argsort(-np.where(direction.usable, lowered, -np.inf))
