"""Conditions at both ends of a linear difference equation: nothing that grows towards the outside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import BoolArray, ComplexArray, FloatArray

UNIT_CIRCLE = 1e-7
"""Distance from the unit circle within which a solution counts as bounded to both sides, and so as causal [1]."""


def at_rest_before(blocks: FloatArray, n_out: int) -> FloatArray:
    """Return the conditions of a solution that decays towards the past, and so begins at rest.

    They exclude every solution x_k ~ mu^k with |mu| <= 1. Solutions on the unit circle, undamped vibrations, are among
    them: they begin with the motion, not before it.

    Args:
        blocks: Derivatives A, B, C of the equation at rest by the unknowns of k - 1, k and k + 1, shape (3, n, n); the
            last rows are those of the output.
        n_out: Number of output equations; those of the first sample are conditions of their own and left out.

    Returns:
        Rows L of L [x_0; x_1] = 0 for the first two samples, shape (number of such mu less n_out, 2 n).
    """
    rows = _orthogonal_to(blocks, lambda alpha, beta: np.abs(alpha) > (1.0 + UNIT_CIRCLE) * np.abs(beta))
    return _beside_output(rows, blocks[1, -n_out:], 0)


def bounded_after(blocks: FloatArray, n_out: int) -> FloatArray:
    """Return the conditions of a solution that does not grow towards the future.

    They exclude every solution x_k ~ mu^k with |mu| > 1.

    Args:
        blocks: As of `at_rest_before`.
        n_out: Number of output equations; those of the last sample are conditions of their own and left out.

    Returns:
        Rows L of L [x_{n-2}; x_{n-1}] = 0 for the last two samples, shape (number of such mu less n_out, 2 n).
    """
    rows = _orthogonal_to(blocks, lambda alpha, beta: np.abs(alpha) <= (1.0 + UNIT_CIRCLE) * np.abs(beta))
    return _beside_output(rows, blocks[1, -n_out:], 1)


def _orthogonal_to(blocks: FloatArray, chosen: Callable[[ComplexArray, FloatArray], BoolArray]) -> FloatArray:
    """Return the orthogonal complement of the solutions with the chosen eigenvalues alpha / beta.

    With w_k = [x_{k-1}, x_k] the equation is E w_{k+1} = F w_k; ordered generalised Schur vectors span the solutions.
    """
    from scipy.linalg import ordqz  # loads slowly

    A, B, C = blocks
    n = len(A)
    zero, one = np.zeros((n, n)), np.eye(n)
    E, F = np.block([[one, zero], [zero, C]]), np.block([[zero, one], [-A, -B]])
    *_, alpha, beta, _, vectors = ordqz(F, E, sort=chosen, output="real")
    count = int(np.count_nonzero(chosen(alpha, beta)))
    return np.asarray(vectors[:, count:].T)


def _beside_output(rows: FloatArray, output: FloatArray, sample: int) -> FloatArray:
    """Return the conditions that remain beside the output's equation of the outer sample.

    They are made insensitive to deviations against the output, which its own equations determine: else its curvature
    would act as a kick, divided by the square of the time step.

    Args:
        rows: Conditions for two samples.
        output: Derivative of the output by the unknowns of one sample, shape (n_out, n).
        sample: Place of the outer sample, 0 or 1.
    """
    own = np.zeros((len(output), 2 * output.shape[1]))
    own[:, sample * output.shape[1] : (sample + 1) * output.shape[1]] = output
    _, _, right = np.linalg.svd(own @ rows.T)
    remaining = right[len(output) :] @ rows
    along = np.eye(output.shape[1]) - np.linalg.pinv(output) @ output
    return np.asarray(remaining @ np.kron(np.eye(2), along))
