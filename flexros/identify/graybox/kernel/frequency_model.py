"""Frequency responses and their Jacobian in machine code, eight frequencies at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from threading import local
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.identify.graybox.kernel.frequency_kernel import kernel_for
from flexros.identify.graybox.kernel.structure import (
    kernel_structure,
    out_of_blocks,
    packed_hold,
    packed_matrices,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.identify.graybox.kernel.frequency_kernel import FrequencyKernel, KernelResponse

Part = TypeVar("Part")


@dataclass(frozen=True, eq=False)
class FactoredJacobian:
    """Responses and the factors of their derivatives.

    The derivative by parameter p is `factors` of p times the product of vector j with itself, or, where j is J + g,
    times the product g of slopes.

    Attributes:
        response: Responses, shape (Q, F, M, M).
        vectors: v, shape (Q, F, J, M).
        slopes: Z^T (dA/dtheta) Z of parameters that are not rank-one terms, shape (Q, F, G, M, M).
        vector_of: j of each parameter, shape (P,).
        factors: -dtheta_p/dx s_p gain (jw)^k, shape (Q, F, P).
    """

    response: ComplexArray
    vectors: ComplexArray
    slopes: ComplexArray
    vector_of: IntArray
    factors: ComplexArray

    def jacobian(self) -> ComplexArray:
        """Multiply the derivatives out, shape (Q, F, M, M, P)."""
        n_vectors = self.vectors.shape[2]
        jacobian = np.empty((*self.response.shape, len(self.vector_of)), complex)
        simple = np.flatnonzero(self.vector_of < n_vectors)
        v = self.vectors[:, :, self.vector_of[simple]].swapaxes(2, 3)
        scaled = v * self.factors[:, :, None, simple]
        jacobian[..., simple] = v[:, :, :, None, :] * scaled[:, :, None, :, :]
        for p in np.flatnonzero(self.vector_of >= n_vectors):
            slope = self.slopes[:, :, self.vector_of[p] - n_vectors]
            jacobian[..., p] = slope * self.factors[:, :, None, None, p]
        return jacobian


@dataclass(frozen=True, eq=False)
class CompiledFrequencyModel:
    """A frequency model in machine code; see `FrequencyModel` for the equations.

    Attributes:
        model: The model in NumPy, used where pivots are so small that rows would have to be exchanged.
        kernel: Code of the model's structure.
        threads: Threads that share the positions.
    """

    model: FrequencyModel
    kernel: FrequencyKernel
    threads: int = 1

    @cached_property
    def _hold(self) -> FloatArray:
        return packed_hold(self.model)

    @cached_property
    def _expansion(self) -> FloatArray:
        rows, columns = np.array(self.kernel.structure.pairs).T
        return np.ascontiguousarray(self.model.expansion[:, :, rows, columns])

    @property
    def _buffer(self) -> KernelResponse:
        """Arrays of this thread, reused: allocation costs more than the computation."""
        if not hasattr(self._memory, "buffer"):
            self._memory.buffer = self.kernel.allocate(*self._hold.shape[:2])
        buffer: KernelResponse = self._memory.buffer
        return buffer

    @cached_property
    def _memory(self) -> local:
        return local()

    @cached_property
    def _workers(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self.threads)

    def response(self, theta: FloatArray) -> ComplexArray:
        """Evaluate the frequency responses; see `FrequencyModel.response`."""
        factored = self.factored_jacobian(theta)
        return self.model.response(theta) if factored is None else factored.response

    def jacobian(self, theta: FloatArray, scale: FloatArray | None = None) -> ComplexArray:
        """Evaluate the derivatives; see `FrequencyModel.jacobian`."""
        factored = self.factored_jacobian(theta, scale)
        return self.model.jacobian(theta, scale) if factored is None else factored.jacobian()

    def factored_jacobian(self, theta: FloatArray, scale: FloatArray | None = None) -> FactoredJacobian | None:
        """Evaluate responses and the factors of their derivatives.

        Args:
            theta: Values of the parameters (SI), shape (P,).
            scale: dtheta/dx of scaled parameters x, shape (P,); default: theta, so that x is the logarithm.

        Returns:
            Responses and factors; None where rows would have to be exchanged.
        """
        structure, n_frequencies = self.kernel.structure, self.model.hold.omega.shape[1]
        results = self._buffer
        small = self.of_parts(
            theta,
            lambda matrices, hold, expansion, part: self.kernel.response(matrices, hold, expansion, results.of(part)),
        )
        if any(small):
            return None
        responses = out_of_blocks(results.responses, n_frequencies)
        factors = out_of_blocks(results.factors, n_frequencies)
        motors, shape = len(structure.motors), factors.shape[:2]
        vectors, slopes = np.split(factors, [len(structure.vectors) * motors], axis=2)
        pair = np.zeros((motors, motors), dtype=np.int64)
        for number, (m, n) in enumerate(structure.pairs):
            pair[m, n] = pair[n, m] = number
        return FactoredJacobian(
            response=np.take(responses, pair, axis=2),
            vectors=vectors.reshape(*shape, len(structure.vectors), motors),
            slopes=np.take(slopes.reshape(*shape, structure.n_slopes, len(structure.pairs)), pair, axis=3),
            vector_of=np.array([vector for vector, _ in structure.parameters], dtype=np.int64),
            factors=self._factors(theta if scale is None else scale),
        )

    def of_parts(
        self, theta: FloatArray, evaluate: Callable[[FloatArray, FloatArray, FloatArray, slice], Part]
    ) -> list[Part]:
        """Evaluate the positions in as many parts as there are threads.

        Args:
            theta: Values of the parameters (SI), shape (P,).
            evaluate: Called with matrices, hold and expansion of some positions, and the slice of these positions.

        Returns:
            Results in the order of the positions.
        """
        matrices = packed_matrices(self.kernel.structure, self.model.positions, theta)
        edges = np.linspace(0, len(matrices), min(self.threads, len(matrices)) + 1).astype(int)
        slices = [slice(int(a), int(b)) for a, b in pairwise(edges)]

        def evaluate_part(part: slice) -> Part:
            return evaluate(matrices[part], self._hold[part], self._expansion[part], part)

        return [evaluate_part(slices[0])] if len(slices) == 1 else list(self._workers.map(evaluate_part, slices))

    def _factors(self, per_step: FloatArray) -> ComplexArray:
        hold, positions = self.model.hold, self.model.positions
        s = 1j * hold.omega
        powers = np.stack([-hold.gain, -hold.gain * s, -hold.gain * s**2], axis=-1)
        of_parameter: ComplexArray = np.take(powers, np.maximum(positions.powers, 0), axis=-1)
        factors: ComplexArray = of_parameter * (per_step * positions.factors)[:, None, :]
        return factors


def compiled_model(model: FrequencyModel, threads: int = 1) -> CompiledFrequencyModel | None:
    """Compile a frequency model; models of equal structure share their code.

    Args:
        model: The model in NumPy.
        threads: Threads that share the positions.

    Returns:
        The compiled model; None without a compiler or for a very large robot.
    """
    kernel = kernel_for(kernel_structure(model.positions))
    return None if kernel is None else CompiledFrequencyModel(model, kernel, threads)
