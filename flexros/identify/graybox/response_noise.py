"""What is known of the covariance of a measured response, steadied over neighbouring lines in short records."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.quantity import derivative_order, differentiation

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse

ENOUGH_DEGREES = 20.0
"""Complex degrees of freedom at which a variance is good enough for a weight (chosen): its spread is 1 / sqrt(20)."""

WIDEST_WINDOW = 5
"""Most neighbours on each side over which the output error is averaged (chosen)."""


@dataclass(frozen=True, eq=False)
class ResponseNoise:
    """Covariance of one position's measured response.

    Attributes:
        error: Covariance of the output error of one experiment, averaged over neighbouring lines, shape (F, n_y, n_y).
        input_inverse: (U U^H)^-1, shape (F, n_u, n_u).
        degrees_of_freedom: Complex degrees of freedom behind `error`.
        kind: "total" (from blocks, distortion included) or "noise" (from periods).
    """

    error: ComplexArray
    input_inverse: ComplexArray
    degrees_of_freedom: float
    kind: str

    @property
    def variance(self) -> FloatArray:
        """Variance of each element E|G - G_0|^2, shape (F, n_y, n_u)."""
        output = np.einsum("fii->fi", self.error).real
        inputs = np.einsum("faa->fa", self.input_inverse).real
        return np.asarray(output[:, :, None] * inputs[:, None, :])

    def covariance(self) -> ComplexArray:
        """Return the covariance of vec G, which stacks columns, shape (F, n_y n_u, n_y n_u)."""
        product = np.einsum("fab,fij->faibj", np.conj(self.input_inverse), self.error)
        n = product.shape[1] * product.shape[2]
        return np.asarray(product.reshape(len(product), n, n))


def response_noise(response: FrequencyResponse) -> ResponseNoise | None:
    """Find the covariance of a response: the total one where it is known, else that of the noise.

    Neighbouring lines are averaged as errors of position, because encoder noise is white in position and so has the
    colour w^4 in acceleration.

    Args:
        response: Measured response of one position.

    Returns:
        The covariance, or None where the record has neither two blocks nor two periods.
    """
    kind = "total" if response.total_error is not None else "noise"
    error = response.total_error if response.total_error is not None else response.noise_error
    if error is None:
        return None
    degrees = max(response.degrees_of_freedom, 1.0)
    half = min(ceil(max(ENOUGH_DEGREES / degrees - 1.0, 0.0) / 2.0), WIDEST_WINDOW, (len(error) - 1) // 2)
    order = derivative_order(response.quantity)
    colour = (np.abs(differentiation(response.frequency, order)) ** 2)[:, None, None]
    steadied = _moving_mean(error / colour, half) * colour
    return ResponseNoise(steadied, response.input_inverse, degrees * (2 * half + 1), kind)


def _moving_mean(values: ComplexArray, half: int) -> ComplexArray:
    """Average over 2 half + 1 lines, at the ends over those there are."""
    if half == 0:
        return values
    total = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
    place = np.arange(len(values))
    first, last = np.maximum(place - half, 0), np.minimum(place + half + 1, len(values))
    mean: ComplexArray = (total[last] - total[first]) / (last - first)[:, None, None]
    return mean
