"""Predictions of a log by a predictor with a fixed gain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class PredictedLog:
    """Predictions of a log by a predictor with a fixed gain, sample by sample.

    Attributes:
        innovations: Measured minus predicted motor positions [rad or m], shape (n, M).
        sd: Standard deviation of the innovations without a gap [rad or m], shape (M,).
        states: Filtered states of the model [SI], arm and motor coordinates, then their rates, shape (n, 2 (N + M));
            None where they were not kept.
        first: First sample that is used; before it the error of the initial state decays.
    """

    innovations: FloatArray
    sd: FloatArray
    states: FloatArray | None = None
    first: int = 0
