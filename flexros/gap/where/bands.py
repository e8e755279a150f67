"""Power of a signal by octave band and regime."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import ifft, next_fast_len

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray

LEAST_LINES = 16
"""Least number of lines of the Fourier transform in the lowest band (chosen)."""


@dataclass(frozen=True, eq=False)
class OctaveBands:
    """Octave bands from the Nyquist frequency down, the lowest one from zero.

    Attributes:
        n_samples: Samples n of the signals.
        sample_time: Time between two samples [s].
        edges: Lines of the Fourier transform at which bands begin and end, shape (B + 1,); line 0 belongs to the first.
    """

    n_samples: int
    sample_time: float
    edges: IntArray

    @classmethod
    def of(cls, n_samples: int, sample_time: float, lowest: float) -> OctaveBands:
        """Divide the frequencies of a log.

        Args:
            n_samples: Samples n of the log.
            sample_time: Time between two samples [s].
            lowest: Least upper end of the lowest band [Hz].
        """
        last = n_samples // 2 + 1
        edges = [last]
        least = max(LEAST_LINES, lowest * n_samples * sample_time)
        while edges[-1] / 2 >= least:
            edges.append(edges[-1] - fast_length_within(edges[-1] - edges[-1] // 2))
        return cls(n_samples, sample_time, np.array([0, *edges[::-1]]))

    @property
    def hz(self) -> FloatArray:
        """Ends of the bands [Hz], shape (B + 1,)."""
        return np.asarray(np.minimum(self.edges / self.n_samples, 0.5) / self.sample_time)

    @property
    def lengths(self) -> IntArray:
        """Number of values over time of each band, shape (B,)."""
        return np.diff(self.edges)

    @cached_property
    def ranges(self) -> IntArray:
        """Runs of neighbouring bands, first and last + 1 of each, single bands first, shape (n_ranges, 2)."""
        count = len(self.lengths)
        runs = [(first, first + width) for width in range(1, count + 1) for first in range(count - width + 1)]
        return np.array(runs)

    def weights(self, masks: FloatArray) -> list[FloatArray]:
        """Average regimes over the time steps of every band.

        Args:
            masks: Weight of each sample in each regime, shape (R, n).

        Returns:
            For each band the mean weight around its values, shape (length of the band, R).
        """
        total = np.concatenate([np.zeros((len(masks), 1)), np.cumsum(masks, axis=1)], axis=1)
        found = []
        for length in self.lengths:
            # value i represents the time around i n / length
            ends = np.clip((np.arange(length + 1) - 0.5) * self.n_samples / length, 0, self.n_samples)
            at = np.array([np.interp(ends, np.arange(self.n_samples + 1), row) for row in total])
            width = np.maximum(np.diff(ends), 1e-9)
            found.append(np.ascontiguousarray((np.diff(at, axis=1) / width).T))
        return found

    def power(self, spectrum: ComplexArray) -> list[FloatArray]:
        """Compute the power of each band over time.

        Args:
            spectrum: Fourier transform of a real signal (scipy.fft.rfft), shape (n // 2 + 1,).

        Returns:
            For each band |band-limited part|^2 times the number of samples per value, so that the sum over all bands
            is that of the squared signal; shape (length of the band,).
        """
        found = []
        for first, end in zip(self.edges[:-1], self.edges[1:]):
            envelope = ifft(spectrum[first:end])
            found.append((envelope.real**2 + envelope.imag**2) * (2 * (end - first) / self.n_samples))
        return found

    def level(self, power: list[FloatArray], shape: FloatArray) -> float:
        """Estimate the level of the noise from the highest band, by the median over time.

        Args:
            power: Power of each band over time.
            shape: Mean of the noise's spectrum over each band, relative to its level, shape (B,).

        Returns:
            Variance of the noise per sample [square of the signal's unit].
        """
        return float(np.median(power[-1]) / (2 * np.log(2) * shape[-1]))


def fast_length_within(length: int) -> int:
    """Return the largest length, at most the given one, whose Fourier transform is fast."""
    while next_fast_len(length, real=True) != length:
        length -= 1
    return length
