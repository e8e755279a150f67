"""Normal equations of frequency responses in machine code."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.kernel_structure import in_blocks
from flexros.identify.graybox.levenberg_marquardt import NormalEquations
from flexros.identify.graybox.normal_equations_text import product_pairs
from flexros.identify.graybox.numpy_least_squares import AbstractLeastSquares, NumpyLeastSquares

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.graybox.compiled_frequency_model import CompiledFrequencyModel
    from flexros.identify.graybox.kernel_structure import KernelStructure
    from flexros.identify.graybox.numpy_least_squares import ResponseTarget


@dataclass(frozen=True, eq=False)
class CompiledLeastSquares(AbstractLeastSquares):
    """Weighted least squares in machine code.

    Attributes:
        model: The compiled model.
        target: What it is compared with.
    """

    model: CompiledFrequencyModel
    target: ResponseTarget

    @cached_property
    def _packed(self) -> FloatArray:
        return packed_target(self.model.kernel.structure, self.target)

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
        factors = np.concatenate([factors, np.ones((len(factors), 1))], axis=1)  # of the error
        first, second = np.array(product_pairs(self.model.kernel.structure)).T
        total = np.sum(sums[:, 1:] * factors[:, first] * factors[:, second], axis=0)
        n = len(theta)
        table = np.zeros((n + 1, n + 1))
        table[first, second] = table[second, first] = 2.0 * total
        return NormalEquations(float(np.sum(sums[:, 0])), table[:n, n].copy(), table[:n, :n].copy())

    def _sums(self, theta: FloatArray) -> FloatArray | None:
        estimator = self.target.estimator
        parts = self.model.of_parts(
            theta,
            lambda matrices, hold, expansion, part: self.model.kernel.sums(
                estimator, matrices, hold, expansion, self._packed[part]
            ),
        )
        return None if any(part.small_pivots for part in parts) else np.concatenate([part.sums for part in parts])


def packed_target(structure: KernelStructure, target: ResponseTarget) -> FloatArray:
    """Bring measured responses and weights into the order of the compiled code.

    Args:
        structure: Structure of the code.
        target: Measured responses, weights and estimator.

    Returns:
        Numbers per element (see `TARGET_NUMBERS`), shape (Q, blocks, pairs * TARGET_NUMBERS, LANES).
    """
    counted = target.weights > 0
    measured = np.where(counted, target.response, 1.0)
    if target.estimator != "NLS":
        measured = np.log(measured)
    m, n = np.array(structure.pairs).T
    second = np.where(m != n, target.weights[:, :, n, m], 0.0)
    total = target.weights[:, :, m, n] + second
    root = np.sqrt(total)
    first, other = measured[:, :, m, n], measured[:, :, n, m]
    numbers = np.stack(
        [
            *(first.real, first.imag, target.weights[:, :, m, n]),
            *(other.real, other.imag, second),
            *(root, np.where(root > 0, 1.0 / np.where(root > 0, root, 1.0), 0.0)),
        ],
        axis=-1,
    )
    return in_blocks(numbers.reshape(*numbers.shape[:2], -1), fill=0.0)
