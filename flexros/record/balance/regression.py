"""Least squares of a torque on a few signals of very different sizes, such as accelerations and signs of speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

ALIKE = 1e-6
"""Singular value over the largest, of signals scaled to the same size, below which two count as alike [1] (chosen)."""


def coefficients(signals: FloatArray, torque: FloatArray) -> FloatArray:
    """Fit a torque by a sum of signals.

    Args:
        signals: The signals, shape (n, k).
        torque: The torque, shape (n,).

    Returns:
        Factor of each signal, shape (k,); the smallest ones where signals are alike.
    """
    size = np.maximum(np.linalg.norm(signals, axis=0), np.finfo(float).tiny)
    factors: FloatArray = np.linalg.lstsq(signals / size, torque, rcond=ALIKE)[0] / size
    return factors
