"""Covariance of a measured response: total with blocks, else of noise alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import CovarianceKind, FrequencyResponse


@dataclass(frozen=True, eq=False)
class ResponseNoise:
    """Covariance of the measured response of one position.

    It was pooled over neighbouring lines when the response was estimated, as `degrees_of_freedom` states. It is not
    averaged again here.

    Attributes:
        response: Measured response of one position.
        kind: "total" (from blocks, distortion included) or "noise" (from periods).
    """

    response: FrequencyResponse
    kind: CovarianceKind

    @property
    def error(self) -> ComplexArray:
        """Covariance of the output error of one experiment, shape (F, n_y, n_y)."""
        return self.response.error(self.kind)

    @property
    def input_inverse(self) -> ComplexArray:
        """(U U^H)^-1, shape (F, n_u, n_u)."""
        return self.response.input_inverse

    @property
    def degrees_of_freedom(self) -> float:
        """Complex degrees of freedom behind `error`, 1 or more."""
        return max(self.response.degrees_of_freedom, 1.0)

    @property
    def variance(self) -> FloatArray:
        """Variance of each element E|G - G_0|^2, shape (F, n_y, n_u)."""
        return np.asarray(self.response.standard_deviation(self.kind) ** 2)

    def covariance(self) -> ComplexArray:
        """Return the covariance of vec G, which stacks columns, shape (F, n_y n_u, n_y n_u)."""
        return self.response.covariance(self.kind)


def response_noise(response: FrequencyResponse) -> ResponseNoise | None:
    """Return the covariance of a response: the total one where it is known, else that of the noise.

    Returns:
        None where the record has neither two blocks nor two periods.
    """
    if response.total_error is None and response.noise_error is None:
        return None
    return ResponseNoise(response, "noise" if response.total_error is None else "total")
