"""Innovations of the prediction errors: the part that earlier errors do not predict.

A missing friction torque changes the prediction errors for as long as it is missing. The time at which it changes its
sign shows in the innovations, the errors of an autoregressive prediction (Yule-Walker; Ljung 1999, section 4.2).
The innovations of white noise are the noise itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from flexros.gap.where.base import AbstractSimulatedView, Location, Statistics, ViewExcess
from flexros.gap.where.regimes import REGIMES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Self

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.channel import ErrorSample
    from flexros.gap.where.prediction_errors import PredictionErrors

ORDER = 32
"""Order of the autoregression (chosen)."""
SIGNAL = "sudden position change"
"""Name of the signal in diagnosis.json."""


class InnovationRegimes(AbstractSimulatedView):
    """Excess of the innovations of the motor positions by regime, P = R locations."""

    name: ClassVar[str] = "innovations"
    rank: ClassVar[int] = 3
    words: ClassVar[Mapping[str, str]] = MappingProxyType({SIGNAL: "sudden changes"})

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each motor."""
        return [cls(channel) for channel in errors.motors]

    @property
    def sized(self) -> BoolArray:
        """Whether each regime has enough samples."""
        return np.asarray(self.channel.masks.sum(axis=1) >= self.channel.settings.least_freedom)

    def statistics(self, sample: ErrorSample) -> Statistics:
        """Sum the squared innovations; the innovations of noise with a known spectrum are the noise it is made of."""
        if sample.white is None:
            innovation = innovations(sample.values)
            values, gain = innovation.values, innovation.noise_gain(self.channel.spectrum)
        else:
            values, gain = sample.white, 1.0
        power = self.channel.masks @ values**2 / (sample.level * gain)
        return Statistics(power, np.cbrt(power), float(power[0]))

    def locations(self, found: ViewExcess) -> Iterator[Location]:
        """List the regimes that occur."""
        channel = self.channel
        for row in np.flatnonzero(channel.time_share > 0):
            regime = channel.regimes[row]
            yield Location(
                signal=SIGNAL,
                joint=channel.joint,
                band_hz=channel.whole_band,
                regime=regime,
                kind=REGIMES[regime].kind,
                share=found.share(found.excess[row]),
                expected=float(channel.time_share[row] / found.n_channels),
                p_value=float(found.p_value[row]),
                least_share=channel.settings.least_share,
                mapped=regime != "all",
            )


@dataclass(frozen=True, eq=False)
class Innovations:
    """Innovations of a signal.

    Attributes:
        values: Error of the autoregressive prediction [unit of the signal], shape (n,); zero for the first samples.
        filter: Filter that computes it from the signal, 1, -a_1, -a_2, ..., shape (p + 1,).
    """

    values: FloatArray
    filter: FloatArray

    def noise_gain(self, spectrum: FloatArray) -> float:
        """Compute the gain of the filter for the power of noise.

        Args:
            spectrum: Spectrum of the noise from zero to the Nyquist frequency, evenly spaced, shape (any,).

        Returns:
            Power of the filtered noise over the mean of the spectrum [1].
        """
        angle = np.pi * (np.arange(len(spectrum)) + 0.5) / len(spectrum)
        response = np.exp(-1j * angle[:, None] * np.arange(len(self.filter))) @ self.filter
        return float((np.abs(response) ** 2 * spectrum).mean())


def innovations(values: FloatArray) -> Innovations:
    """Compute the innovations of a signal.

    Args:
        values: The signal, shape (n,).
    """
    n = len(values)
    order = min(ORDER, n // 50)
    size = next_fast_len(n + order + 1)
    spectrum = rfft(values, size)
    covariance = irfft(spectrum.real**2 + spectrum.imag**2, size)[: order + 1]
    if order == 0 or covariance[0] <= 0:
        return Innovations(np.array(values, dtype=float), np.ones(1))
    covariance[0] *= 1 + 1e-9  # keeps nearly periodic signals solvable
    coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    inverse = np.concatenate([[1.0], -coefficients])
    filtered = np.asarray(lfilter(inverse, [1.0], values), dtype=float)
    filtered[:order] = 0.0
    return Innovations(filtered, inverse)
