"""Normal equations of frequency responses in machine code."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.numpy_least_squares import AbstractLeastSquares, NumpyLeastSquares
from flexros.prediction.damped_least_squares import NormalEquations

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.graybox.kernel.frequency_model import CompiledFrequencyModel
    from flexros.identify.graybox.numpy_least_squares import ResponseTarget


@dataclass(frozen=True, eq=False)
class CompiledLeastSquares(AbstractLeastSquares):
    """Weighted least squares in machine code.

    Attributes:
        model: The compiled model.
        target: Measured responses and weights.
    """

    model: CompiledFrequencyModel
    target: ResponseTarget

    @cached_property
    def _last(self) -> dict[bytes, FloatArray | None]:
        """Sums of the last parameters: a search evaluates the cost of a trial, then its normal equations."""
        return {}

    @cached_property
    def _by_numpy(self) -> NumpyLeastSquares:
        return NumpyLeastSquares(self.model.model, self.target)

    def cost(self, theta: FloatArray) -> float:
        """Evaluate the cost; see `AbstractLeastSquares.cost`."""
        sums = self._sums(theta)
        return self._by_numpy.cost(theta) if sums is None else float(np.sum(sums[:, 0]))

    def normal_equations(self, theta: FloatArray, scale: FloatArray | None = None) -> NormalEquations:
        """Evaluate the normal equations; see `AbstractLeastSquares.normal_equations`."""
        sums = self._sums(theta)
        if sums is None:
            return self._by_numpy.normal_equations(theta, scale)
        per_step = theta if scale is None else scale
        factors = per_step * self.model.model.positions.factors
        factors = np.concatenate([factors, np.ones((len(factors), 1))], axis=1)  # column of the error
        first, second = self.model.kernel.pairs
        total = np.sum(sums[:, 1:] * factors[:, first] * factors[:, second], axis=0)
        n = len(theta)
        table = np.zeros((n + 1, n + 1))
        table[first, second] = table[second, first] = 2.0 * total
        return NormalEquations(float(np.sum(sums[:, 0])), table[:n, n].copy(), table[:n, :n].copy())

    def _sums(self, theta: FloatArray) -> FloatArray | None:
        """Cost and product pairs of every position; None where rows would have to be exchanged."""
        key = theta.tobytes()
        if key in self._last:
            return self._last[key]
        target = self.target.packed
        parts = self.model.of_parts(
            theta,
            lambda matrices, hold, expansion, part: self.model.kernel.sums(
                self.target.estimator, matrices, hold, expansion, target[part]
            ),
        )
        exchange = any(part.small_pivots for part in parts)
        sums = None if exchange else np.concatenate([part.sums for part in parts])
        self._last.clear()
        self._last[key] = sums
        return sums
