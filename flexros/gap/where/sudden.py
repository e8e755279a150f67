"""The sudden part of prediction errors: what the errors just before do not foretell.

A missing friction torque shows in the prediction errors all the time that it is missing; when it changes its sign is
told by the part that earlier errors do not foretell. This part is the error of an autoregressive prediction (Yule-
Walker; Ljung 1999, section 4.2). Of white noise it is the noise itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

ORDER = 32
"""Past samples that foretell the next one (chosen)."""


@dataclass(frozen=True, eq=False)
class SuddenPart:
    """What is sudden in a signal.

    Attributes:
        values: The error of its autoregressive prediction [unit of the signal], shape (n,); zero for the first samples.
        filter: The filter that the signal was led through, 1, -a_1, -a_2, ..., shape (p + 1,).
    """

    values: FloatArray
    filter: FloatArray

    def noise_gain(self, spectrum: FloatArray) -> float:
        """Tell how much the filter amplifies the power of noise.

        Args:
            spectrum: Spectrum of the noise from zero to the Nyquist frequency, evenly spaced, shape (any,).

        Returns:
            Power of the filtered noise over the mean of the spectrum [1].
        """
        angle = np.pi * (np.arange(len(spectrum)) + 0.5) / len(spectrum)
        response = np.exp(-1j * angle[:, None] * np.arange(len(self.filter))) @ self.filter
        return float((np.abs(response) ** 2 * spectrum).mean())


def sudden_part(values: FloatArray) -> SuddenPart:
    """Compute what is sudden in a signal.

    Args:
        values: The signal, shape (n,).

    Returns:
        The part.
    """
    n = len(values)
    order = min(ORDER, n // 50)
    size = next_fast_len(n + order + 1)
    spectrum = rfft(values, size)
    covariance = irfft(spectrum.real**2 + spectrum.imag**2, size)[: order + 1]
    if order == 0 or covariance[0] <= 0:
        return SuddenPart(np.array(values, dtype=float), np.ones(1))
    covariance[0] *= 1 + 1e-9  # keeps nearly periodic signals solvable
    coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    inverse = np.concatenate([[1.0], -coefficients])
    found = np.asarray(lfilter(inverse, [1.0], values), dtype=float)
    found[:order] = 0.0
    return SuddenPart(found, inverse)
