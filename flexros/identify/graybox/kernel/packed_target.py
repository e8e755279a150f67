"""Measured responses and weights in the order of the compiled code."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.kernel.structure import in_blocks, motor_pairs

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray


def packed_target(response: ComplexArray, weights: FloatArray, logarithmic: bool) -> FloatArray:
    """Bring measured responses and weights into blocks.

    Args:
        response: Measured responses, shape (Q, F, M, M); anything where the weight is zero.
        weights: Weights, shape (Q, F, M, M).
        logarithmic: Whether logarithms of the responses are compared.

    Returns:
        For each pair (m, n) of motors: measured (m, n) as two numbers, weight; the same of (n, m), with weight 0 where
        m = n; square root of the sum of both weights and its inverse (0 for 0); shape (Q, blocks, 8 pairs, LANES).
    """
    measured = np.where(weights > 0, response, 1.0)
    if logarithmic:
        measured = np.log(measured)
    m, n = np.array(motor_pairs(measured.shape[-1])).T
    second = np.where(m != n, weights[:, :, n, m], 0.0)
    root = np.sqrt(weights[:, :, m, n] + second)
    first, other = measured[:, :, m, n], measured[:, :, n, m]
    numbers = [
        *(first.real, first.imag, weights[:, :, m, n]),
        *(other.real, other.imag, second),
        *(root, np.where(root > 0, 1.0 / np.where(root > 0, root, 1.0), 0.0)),
    ]
    return in_blocks(np.stack(numbers, axis=-1).reshape(*root.shape[:2], -1), fill=0.0)
