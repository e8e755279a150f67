"""One signal in which a gap is located: a motor position or a component of the tool position."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, rfft

from flexros.gap.where.bands import OctaveBands, fast_length_within

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.gap.settings import WhereSettings
    from flexros.record.record import Record

SAMPLED_REGIMES = ("all", "standstill", "reversal", "high speed", "vibration", "first third", "last third")
"""Regimes of a signal of several motors: one holds where it holds for any motor, standstill where it does for all."""


class Channel:
    """A signal with its octave bands, its regimes and the spectrum of its noise.

    Args:
        joint: Name of the joint, or "tool".
        values: Prediction errors, in standard deviations of their noise where these are known, shape (n,).
        bands: Octave bands of the signal.
        masks: Samples of each of R regimes by name, shape (n,) each; the first regime holds all samples.
        valid: Samples that were measured, shape (n,).
        spectrum: Spectrum of the noise from zero to the Nyquist frequency, evenly spaced, shape (any,).
        settings: Settings of the search.
        estimate_level: Whether the level of the noise is estimated from the highest octave; otherwise it is one.
        rotor: Rotor angle [rad] and rate of the motor coordinate [rad/s or m/s], shape (n,) each; None for the tool.
    """

    def __init__(
        self,
        joint: str,
        values: FloatArray,
        bands: OctaveBands,
        masks: Mapping[str, BoolArray],
        valid: BoolArray,
        spectrum: FloatArray,
        settings: WhereSettings,
        *,
        estimate_level: bool,
        rotor: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.joint = joint
        self.values = values
        self.bands = bands
        self.regimes = tuple(masks)
        self.valid = valid
        self.spectrum = spectrum
        self.settings = settings
        self.rotor = rotor
        self.masks = np.array([mask & valid for mask in masks.values()], dtype=float)
        self.weights = bands.weights(self.masks)
        self._estimate_level = estimate_level
        middles = (np.arange(len(spectrum)) + 0.5) / len(spectrum)
        lines = np.interp(np.linspace(0, 1, bands.n_samples // 2 + 1), middles, spectrum)
        self._white = bool(np.ptp(spectrum) < 1e-9 * np.mean(spectrum))
        self._root = np.sqrt(lines)
        self._shape = np.array([lines[first:end].mean() for first, end in zip(bands.edges[:-1], bands.edges[1:])])

    @property
    def time_share(self) -> FloatArray:
        """Share of the valid samples in each regime [1], shape (R,)."""
        return np.asarray(self.masks.sum(axis=1) / max(float(self.valid.sum()), 1.0))

    @property
    def whole_band(self) -> tuple[float, float]:
        """Frequencies from zero to the Nyquist frequency [Hz]."""
        return 0.0, float(self.bands.hz[-1])

    def measured(self) -> ErrorSample:
        """Return the measured errors, zero where nothing was measured."""
        values = np.where(self.valid, self.values, 0.0)
        return self._sample(rfft(values), values=values)

    def simulated(self, random: np.random.Generator) -> ErrorSample:
        """Draw errors without a gap.

        Args:
            random: Random number generator of this channel and simulated log.
        """
        white = random.standard_normal(self.bands.n_samples)
        spectrum = rfft(white) if self._white else rfft(white) * self._root
        if not self.valid.all():
            spectrum = rfft(np.where(self.valid, irfft(spectrum, self.bands.n_samples), 0.0))
        return self._sample(spectrum, white=white, random=random)

    def _sample(
        self,
        spectrum: ComplexArray,
        values: FloatArray | None = None,
        white: FloatArray | None = None,
        random: np.random.Generator | None = None,
    ) -> ErrorSample:
        power = self.bands.power(spectrum)
        level = max(self.bands.level(power, self._shape), 1e-300) if self._estimate_level else 1.0
        per_band = np.array([weights.T @ over_time for weights, over_time in zip(self.weights, power)])
        return ErrorSample(self.bands.n_samples, spectrum, per_band / level, level, values, white, random)


@dataclass(frozen=True, eq=False)
class ErrorSample:
    """Prediction errors of one channel, measured or simulated without a gap.

    Attributes:
        n_samples: Number of samples n.
        spectrum: Fourier transform of the errors (scipy.fft.rfft), shape (n // 2 + 1,).
        band_power: Power by octave band and regime, over `level`, shape (B, R).
        level: Variance of the noise per sample [square of the signal's unit].
        measured: The errors where they were measured, shape (n,); None for simulated ones.
        white: White noise of variance one that simulated errors are made of, shape (n,); None for measured ones.
        random: Random number generator of simulated errors, from which a view may draw what it would otherwise
            transform; None for measured ones.
    """

    n_samples: int
    spectrum: ComplexArray
    band_power: FloatArray
    level: float
    measured: FloatArray | None
    white: FloatArray | None
    random: np.random.Generator | None

    @cached_property
    def values(self) -> FloatArray:
        """The errors over time, shape (n,)."""
        return np.asarray(irfft(self.spectrum, self.n_samples)) if self.measured is None else self.measured

    @property
    def total(self) -> float:
        """Power of all samples over the level of the noise."""
        return float(np.cumsum(self.band_power[:, 0])[-1])


def sampled_channel(
    joint: str,
    time: FloatArray,
    values: FloatArray,
    valid: BoolArray,
    motors: Sequence[Channel],
    record: Record,
    settings: WhereSettings,
) -> Channel:
    """Prepare a signal with times of its own; its first values are left out for a fast Fourier transform.

    Args:
        joint: Name of the joint, or "tool".
        time: Time of each value since the start of the log [s], shape (m,).
        values: Prediction errors, shape (m,).
        valid: Values that were measured, shape (m,).
        motors: Channels of the motors whose `SAMPLED_REGIMES` it has.
        record: The log.
        settings: Settings of the search.
    """
    sample_time = float(time[-1] - time[0]) / max(len(time) - 1, 1)
    bands = OctaveBands.of(fast_length_within(len(time)), sample_time, settings.lowest_hz)
    n, kept = motors[0].bands.n_samples, slice(-bands.n_samples, None)
    rows = np.clip(np.round(time[kept] / record.sample_time).astype(int) - (record.n_samples - n), 0, n - 1)
    masks = {}
    for name in SAMPLED_REGIMES:
        of_motors = [motor.masks[motor.regimes.index(name)][rows] > 0 for motor in motors]
        masks[name] = np.all(of_motors, axis=0) if name == "standstill" else np.any(of_motors, axis=0)
    return Channel(joint, values[kept], bands, masks, valid[kept], np.ones(2), settings, estimate_level=True)
