"""The sudden part of prediction errors: what the errors just before do not foretell.

A missing friction torque shows in the prediction errors all the time that it is missing; when it changes its sign is
told by the part that earlier errors do not foretell. This part is the error of an autoregressive prediction (Yule-
Walker; Ljung 1999, section 4.2). Of white noise it is the noise itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

ORDER = 32
"""Past samples that foretell the next one (chosen)."""
NORMAL_MEDIAN = 0.4549364
"""Median of the square of a standard normal variable."""


def sudden_part(values: FloatArray) -> FloatArray:
    """Compute what is sudden in a signal.

    Args:
        values: The signal, shape (n,).

    Returns:
        The error of its autoregressive prediction [unit of the signal], shape (n,); zero for the first samples.
    """
    n = len(values)
    order = min(ORDER, n // 50)
    size = next_fast_len(n + order + 1)
    spectrum = rfft(values, size)
    covariance = irfft(spectrum.real**2 + spectrum.imag**2, size)[: order + 1]
    if order == 0 or covariance[0] <= 0:
        return np.array(values, dtype=float)
    covariance[0] *= 1 + 1e-9  # keeps nearly periodic signals solvable
    coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    found = np.asarray(lfilter(np.concatenate([[1.0], -coefficients]), [1.0], values), dtype=float)
    found[:order] = 0.0
    return found


def level(values: FloatArray) -> float:
    """Estimate the variance of noise among which there are rare large values, by the median.

    Args:
        values: The signal, shape (n,).
    """
    return float(np.median(values**2) / NORMAL_MEDIAN)
