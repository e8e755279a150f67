"""One signal in which a gap is looked for: a motor's position, or the tool's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, rfft

from flexros.gap.where.order_spectrum import OrderGrid, prominence
from flexros.gap.where.sudden import sudden_part

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.gap.where.bands import OctaveBands

LEAST_FREEDOM = 8.0
"""Degrees of freedom that a place needs (chosen)."""


@dataclass(frozen=True, eq=False)
class Look:
    """What one signal shows in all its places.

    Attributes:
        bands: Excess statistic (power over the level of the noise) by run of bands and regime, shape (n_ranges, R).
        sudden: The same of the sudden part, by regime, shape (R,).
        orders: Power over the level of the noise by order, shape (K,).
        prominence: How far orders stand out of their neighbours, shape (K,).
    """

    bands: FloatArray
    sudden: FloatArray
    orders: FloatArray
    prominence: FloatArray

    def statistics(self) -> FloatArray:
        """Return the statistics of all places; cube roots of powers are nearly normal (Wilson & Hilferty 1931)."""
        return np.concatenate([np.cbrt(self.bands).ravel(), np.cbrt(self.sudden), self.prominence])


class Channel:
    """A signal with its bands, regimes and orders.

    Args:
        joint: Name of the joint, or "tool".
        bands: Octave bands of the signal.
        masks: Samples of each regime by its name, shape (n,) each.
        valid: Samples that were measured, shape (n,).
        spectrum: Spectrum of the noise from zero to the Nyquist frequency, shape (any number,).
        orders: Samples by rotor angle; None where there is no rotor.
        estimate_level: Whether the level of the noise is that of the highest octave; else it is one.
    """

    def __init__(
        self,
        joint: str,
        bands: OctaveBands,
        masks: Mapping[str, BoolArray],
        valid: BoolArray,
        spectrum: FloatArray,
        orders: OrderGrid | None,
        estimate_level: bool,
    ) -> None:
        self.joint = joint
        self.bands = bands
        self.regimes = tuple(masks)
        self.valid = valid
        self.orders = orders
        self.estimate_level = estimate_level
        self.masks = np.array([mask & valid for mask in masks.values()], dtype=float)
        self._weights = bands.weights(self.masks)
        lines = np.interp(np.linspace(0, 1, bands.n_samples // 2 + 1), _middles(len(spectrum)), spectrum)
        self._spectrum = spectrum
        self._white = bool(np.ptp(spectrum) < 1e-9 * np.mean(spectrum))
        self._root = np.sqrt(lines)
        self._shape = np.array([lines[first:end].mean() for first, end in zip(bands.edges[:-1], bands.edges[1:])])

    @property
    def time_share(self) -> FloatArray:
        """Share of the log that each regime takes [1], shape (R,)."""
        return np.asarray(self.masks.sum(axis=1) / max(float(self.valid.sum()), 1.0))

    @property
    def sized(self) -> BoolArray:
        """Whether a place is large enough, in the order of `Look.statistics`, shape (P,)."""
        per_band = 2 * np.array([weights.sum(axis=0) for weights in self._weights])
        freedom = self._runs(per_band)
        order_count = 0 if self.orders is None else len(self.orders.orders)
        return np.concatenate(
            [
                freedom.ravel() >= LEAST_FREEDOM,
                self.masks.sum(axis=1) >= LEAST_FREEDOM,
                np.ones(order_count, dtype=bool),
            ]
        )

    def shown(self, values: FloatArray) -> FloatArray:
        """Leave out the first samples of a signal, which are not looked at.

        Args:
            values: The signal, shape (any number above n,).
        """
        return values[-self.bands.n_samples :]

    def look(self, values: FloatArray) -> Look:
        """Look at a measured signal.

        Args:
            values: The signal in units of its noise, shape (n,).
        """
        shown = np.where(self.valid, values, 0.0)
        sudden = sudden_part(shown)
        orders = np.zeros((0, 0)) if self.orders is None else self.orders.power(shown)
        return self._look(rfft(shown), sudden.values, sudden.noise_gain(self._spectrum), orders)

    def noise(self, random: np.random.Generator) -> Look:
        """Draw a signal without gap and look at it.

        Args:
            random: Generator of random numbers.
        """
        fresh = random.standard_normal(self.bands.n_samples)
        spectrum = rfft(fresh) if self._white else rfft(fresh) * self._root
        if not self.valid.all():
            spectrum = rfft(np.where(self.valid, irfft(spectrum, self.bands.n_samples), 0.0))
        orders = np.zeros((0, 0)) if self.orders is None else self.orders.noise(random)
        # of noise with a known spectrum the sudden part is what it was made from
        return self._look(spectrum, fresh, 1.0, orders)

    def _look(self, spectrum: ComplexArray, fresh: FloatArray, gain: float, orders: FloatArray) -> Look:
        power = self.bands.power(spectrum)
        floor = max(self.bands.level(power, self._shape), 1e-300) if self.estimate_level else 1.0
        per_band = np.array([weights.T @ one for weights, one in zip(self._weights, power)])
        return Look(
            bands=self._runs(per_band / floor),
            sudden=self.masks @ fresh**2 / (floor * gain),
            orders=orders.sum(axis=0) / floor,
            prominence=prominence(orders) if orders.size else np.zeros(orders.shape[1]),
        )

    def _runs(self, per_band: FloatArray) -> FloatArray:
        """Sum over every run of bands, shape (n_ranges, R)."""
        total = np.concatenate([np.zeros((1, per_band.shape[1])), np.cumsum(per_band, axis=0)])
        ranges = self.bands.ranges
        return np.asarray(total[ranges[:, 1]] - total[ranges[:, 0]])


def _middles(count: int) -> FloatArray:
    return (np.arange(count) + 0.5) / count
