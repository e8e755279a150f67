"""Measured responses and weights in the order of the compiled code."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from flexros.identify.graybox.kernel_structure import in_blocks, motor_pairs

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.graybox.numpy_least_squares import ResponseTarget

_PACKED: WeakKeyDictionary[ResponseTarget, FloatArray] = WeakKeyDictionary()


def packed_target(target: ResponseTarget) -> FloatArray:
    """Bring measured responses (their logarithms, unless the estimator is NLS) and weights into blocks.

    A target is packed once, however often the robot is linearised anew for it.

    Args:
        target: Measured responses, weights and estimator.

    Returns:
        For each pair (m, n) of motors: measured (m, n) as two numbers, weight; the same of (n, m), with weight 0 where
        m = n; square root of the sum of both weights and its inverse (0 for 0); shape (Q, blocks, 8 pairs, LANES).
    """
    if target not in _PACKED:
        _PACKED[target] = _packed(target)
    return _PACKED[target]


def _packed(target: ResponseTarget) -> FloatArray:
    counted = target.weights > 0
    measured = np.where(counted, target.response, 1.0)
    if target.estimator != "NLS":
        measured = np.log(measured)
    m, n = np.array(motor_pairs(measured.shape[-1])).T
    second = np.where(m != n, target.weights[:, :, n, m], 0.0)
    total = target.weights[:, :, m, n] + second
    root = np.sqrt(total)
    first, other = measured[:, :, m, n], measured[:, :, n, m]
    numbers = [
        *(first.real, first.imag, target.weights[:, :, m, n]),
        *(other.real, other.imag, second),
        *(root, np.where(root > 0, 1.0 / np.where(root > 0, root, 1.0), 0.0)),
    ]
    return in_blocks(np.stack(numbers, axis=-1).reshape(*root.shape[:2], -1), fill=0.0)
