"""A log as a fit sees it: with gain, start, and weights of its prediction errors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.gain import ObserverGain
    from flexros.gap.predictor import Predictor
    from flexros.gap.record import GapRecord


@dataclass(frozen=True, eq=False)
class FitData:
    """Log and what the fit needs to weigh its prediction errors.

    Attributes:
        record: The log.
        gain: Gain of the predictor.
        start: State of the robot before the first sample, shape (2 n_coordinates,).
        spread: Standard deviation of a prediction error without gap [rad or m], shape (n, M); infinite where a sample
            was not measured or the start has not decayed.
        whitening: Coefficients of the filter 1 + a_1 z^-1 + ... that makes the errors white without gap, per motor,
            shape (M, order + 1).
    """

    record: GapRecord
    gain: ObserverGain
    start: FloatArray
    spread: FloatArray
    whitening: FloatArray

    @property
    def n_values(self) -> int:
        """Number of prediction errors that count."""
        return int(np.isfinite(self.spread).sum())

    def residuals(self, predictor: Predictor, thetas: FloatArray) -> FloatArray:
        """Predict and weigh.

        Args:
            predictor: The hypothesis.
            thetas: Numbers, shape (n_fitted, sets) with at most `LANES` sets.

        Returns:
            Weighted prediction errors, each of variance 1 without gap, shape (n_values', sets).
        """
        prediction = predictor.predict(thetas, self.record, self.gain, self.start)
        innovation = prediction.innovation[:, :, : thetas.shape[1]]
        return self.weighted(innovation)

    def weighted(self, innovation: FloatArray) -> FloatArray:
        """Weigh prediction errors.

        Args:
            innovation: Prediction errors [rad or m], shape (n, M, sets).

        Returns:
            Weighted prediction errors, shape (n M, sets); zero where they do not count.
        """
        n, M, sets = innovation.shape
        result = np.empty((M, n, sets))
        for motor in range(M):
            white = innovation[:, motor]
            if self.whitening.shape[1] > 1:
                white = lfilter(self.whitening[motor], [1.0], white, axis=0)
            np.multiply(white, self._weight[:, motor, None], out=result[motor])
        return result.reshape(M * n, sets)

    @cached_property
    def _weight(self) -> FloatArray:
        return 1.0 / self.spread


def constant_spread(record: GapRecord, gain: ObserverGain) -> FloatArray:
    """Give every measured sample behind the transient the same standard deviation.

    Args:
        record: The log.
        gain: Gain of the predictor, with the spread that it gives to noise.

    Returns:
        Standard deviations, infinite where samples do not count, shape (n, M).
    """
    spread = np.repeat(gain.spread[None], record.n_samples, axis=0)
    spread[: min(gain.settling, record.n_samples // 4)] = np.inf
    spread[~record.valid] = np.inf
    return spread
