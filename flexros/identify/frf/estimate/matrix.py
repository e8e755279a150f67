"""Response matrices from the spectra of several experiments: block by block, or all blocks at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.settings import Average

SMALLEST_RATIO = 1e-7
"""Smallest over largest singular value of the inputs, scaled to equal size, of independent experiments (chosen)."""


@dataclass(frozen=True, eq=False)
class MatrixEstimate:
    """An estimate G = Y W with U W = I (to first order in the noise for a logarithmic mean).

    Attributes:
        response: G, shape (F, n_y, n_u).
        weights: W, shape (F, m, n_u).
    """

    response: ComplexArray
    weights: ComplexArray

    @property
    def input_inverse(self) -> ComplexArray:
        """W^H W, shape (F, n_u, n_u); (U U^H)^-1 for least squares."""
        return np.asarray(adjoint(self.weights) @ self.weights)


def adjoint(matrices: ComplexArray) -> ComplexArray:
    """Return the conjugate transpose of each matrix of a stack, shape (..., n, m) for (..., m, n).

    Args:
        matrices: The stack.
    """
    return np.asarray(np.conj(np.swapaxes(matrices, -1, -2)))


def estimate(
    inputs: ComplexArray,
    outputs: ComplexArray,
    reference: ComplexArray | None,
    block: IntArray,
    average: Average,
    frequency: FloatArray,
) -> MatrixEstimate:
    """Estimate G from Y = G U of m experiments.

    Joint: Y U^H (U U^H)^-1, and with a known reference Y R^H (U R^H)^-1, which noise in U does not bias (instrumental
    variables and errors in variables: Pintelon & Schoukens 2012, chapter 2). Arithmetic and logarithmic: the mean over
    blocks of Y_b U_b^-1, (4.7) of Moberg (2007) and (2) of its Paper A; of its logarithm for the latter.

    Args:
        inputs: U, shape (F, n_u, m).
        outputs: Y, shape (F, n_y, m).
        reference: R, shape (F, n_r, m), n_r >= n_u; None where it is not known.
        block: Block of each experiment, shape (m,).
        average: How blocks are combined.
        frequency: Frequencies [Hz], shape (F,), for messages.

    Raises:
        InputError: There are too few independent experiments.
    """
    check_independent(inputs, frequency)
    if average == "joint":
        weights = right_inverse(inputs, reference)
        return MatrixEstimate(outputs @ weights, weights)
    return _mean_of_blocks(inputs, outputs, reference, block, average == "logarithmic", frequency)


def right_inverse(inputs: ComplexArray, reference: ComplexArray | None) -> ComplexArray:
    """Return W with U W = I: U^H (U U^H)^-1, or with a reference the same for the part of U that it causes.

    Args:
        inputs: U, shape (F, n_u, m).
        reference: R, shape (F, n_r, m), or None.

    Returns:
        W, shape (F, m, n_u).
    """
    instrument = inputs
    if reference is not None:
        instrument = (inputs @ np.linalg.pinv(reference)) @ reference
    return np.asarray(adjoint(instrument) @ np.linalg.inv(inputs @ adjoint(instrument)))


def check_independent(inputs: ComplexArray, frequency: FloatArray) -> None:
    """Reject experiments that do not excite all inputs independently.

    Args:
        inputs: U, shape (F, n_u, m).
        frequency: Frequencies [Hz], shape (F,).

    Raises:
        InputError: Fewer experiments than inputs, or linearly dependent inputs.
    """
    n_u, m = inputs.shape[1:]
    if m < n_u:
        raise InputError(
            f"{m} experiments cannot determine the response to {n_u} inputs, at least {n_u} are needed; "
            "record a block of as many experiments as there are motors"
        )
    size = np.linalg.norm(inputs, axis=2, keepdims=True)
    if not np.all(size > 0):
        k, motor = (int(index) for index in np.argwhere(size[:, :, 0] == 0)[0])
        raise InputError(
            f"no excitation: input {motor + 1} is zero at {frequency[k]:g} Hz; excite every motor at every line"
        )
    singular = np.linalg.svd(inputs / size, compute_uv=False)
    ratio = singular[:, -1] / singular[:, 0]
    if ratio.min() < SMALLEST_RATIO:
        raise InputError(
            f"the experiments are not independent at {frequency[ratio.argmin()]:g} Hz (ratio of singular values of the "
            f"inputs {ratio.min():.2g}, allowed is {SMALLEST_RATIO:g} or more); use an orthogonal multisine or others"
        )


def _mean_of_blocks(
    inputs: ComplexArray,
    outputs: ComplexArray,
    reference: ComplexArray | None,
    block: IntArray,
    logarithmic: bool,
    frequency: FloatArray,
) -> MatrixEstimate:
    blocks = np.unique(block)
    weights = np.zeros((len(inputs), inputs.shape[2], inputs.shape[1]), dtype=complex)
    responses = []
    for value in blocks:
        members = block == value
        check_independent(inputs[:, :, members], frequency)
        part = right_inverse(inputs[:, :, members], None if reference is None else reference[:, :, members])
        responses.append(outputs[:, :, members] @ part)
        weights[:, members] = part / len(blocks)
    mean = logarithmic_mean(np.array(responses)) if logarithmic else np.mean(responses, axis=0)
    return MatrixEstimate(mean, weights)


def logarithmic_mean(responses: ComplexArray) -> ComplexArray:
    """Return exp(mean(log G)), entry by entry, with log G = log|G| + j arg G (geometric mean).

    The argument of each entry is taken relative to the arithmetic mean, so that it has no jump of 2 pi.

    Args:
        responses: Responses to average over, shape (B, F, n_y, n_u).

    Returns:
        Mean, shape (F, n_y, n_u); 0 where a response is 0.
    """
    base = responses.mean(axis=0)
    base = np.where(base == 0, 1.0, base)
    ratio = responses / base
    zero = np.any(ratio == 0, axis=0)
    mean = base * np.exp(np.log(np.where(zero, 1.0, ratio)).mean(axis=0))
    return np.asarray(np.where(zero, 0.0, mean))
