"""Order spectrum: what repeats with the turning of a rotor, told apart from what repeats in time by several speeds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import next_fast_len, rfft

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray

BINS_PER_PERIOD = 4
"""Parts of the shortest period over which samples are summed (chosen)."""
LEAST_PERIODS = 3
"""Periods of the lowest order that the rotor turns through (chosen)."""
BACKGROUND = 21
"""Neighbouring orders whose median is the background of a peak (chosen)."""
MOST_BINS = 2**17
"""Longest transform; beyond it only the lower orders are looked at (chosen)."""
MOVING = 0.03
"""Share of the largest speed above which a rotor counts as turning (chosen)."""
SPEEDS = 3
"""Groups of similar speed in each direction (chosen)."""
LEAST_SAMPLES = 200
"""Samples that a group of like speed needs (chosen)."""


@dataclass(frozen=True, eq=False)
class OrderGrid:
    """Samples of a motor in motion by the angle of its rotor, in groups of equal direction and similar speed.

    Attributes:
        orders: Orders looked at [periods per turn], shape (K,); empty where the rotor turns too little.
        first: Line of the first of them in a transform.
        n_bins: Parts of the angle.
        groups: Rows of the samples of each group.
        places: Part of the angle of each of these rows, by group.
    """

    orders: FloatArray
    first: int
    n_bins: int
    groups: tuple[IntArray, ...]
    places: tuple[IntArray, ...]

    @classmethod
    def of(cls, angle: FloatArray, speed: FloatArray, valid: BoolArray, highest: float) -> OrderGrid:
        """Sort the samples of a motor.

        Args:
            angle: Rotor angle [rad], shape (n,).
            speed: Rate of the motor coordinate [rad/s or m/s], shape (n,).
            valid: Samples to use, shape (n,).
            highest: Highest order [periods per turn].
        """
        empty = cls(np.zeros(0), 0, 0, (), ())
        moving = valid & (np.abs(speed) > MOVING * np.quantile(np.abs(speed), 0.999))
        if moving.sum() < 4 * LEAST_SAMPLES:
            return empty
        begin, end = float(angle[moving].min()), float(angle[moving].max())
        width = max(2 * np.pi / (BINS_PER_PERIOD * highest), (end - begin) / MOST_BINS)
        n_bins = next_fast_len(int((end - begin) / width) + 1, real=True)
        orders = np.arange(n_bins // 2 + 1) * 2 * np.pi / (n_bins * width)
        wanted = (np.arange(len(orders)) >= LEAST_PERIODS) & (orders <= min(highest, orders[-1] / 2 + 1e-9))
        if wanted.sum() < BACKGROUND:
            return empty
        groups = _groups(speed, moving)
        places = tuple(((angle[rows] - begin) / width).astype(np.int64) for rows in groups)
        return cls(orders[wanted], int(np.flatnonzero(wanted)[0]), n_bins, groups, places)

    def power(self, values: FloatArray) -> FloatArray:
        """Compute the order spectrum of a signal, group by group.

        Args:
            values: The signal, shape (n,).

        Returns:
            Sum of squares that a sinusoid of each order explains [square of the signal's unit], shape (groups, K).
        """
        if not self.groups:
            return np.zeros((0, len(self.orders)))
        sums = []
        for rows, place in zip(self.groups, self.places):
            inside = values[rows]
            sums.append(np.bincount(place, weights=inside - inside.mean(), minlength=self.n_bins))
        return self._of_sums(np.array(sums, dtype=float).reshape(len(self.groups), self.n_bins))

    def between(self, place: int, power: FloatArray) -> float:
        """Place the top of a peak between orders, by a parabola through the logarithms of power.

        Args:
            place: Number of the largest order of the peak.
            power: Power of the order before, itself and the order behind, shape (3,).

        Returns:
            The order of the top [periods per turn].
        """
        low, middle, high = np.log(np.maximum(power, 1e-300))
        bend = low - 2 * middle + high
        shift = 0.5 * (low - high) / bend if bend < 0 else 0.0
        return float(self.orders[place] + np.clip(shift, -0.5, 0.5) * (self.orders[1] - self.orders[0]))

    def noise(self, random: np.random.Generator) -> FloatArray:
        """Draw the order spectrum of white noise of variance one, as `power` gives it.

        Args:
            random: Generator of random numbers.
        """
        if not self.groups:
            return np.zeros((0, len(self.orders)))
        return self._of_sums(self._spread * random.standard_normal(self._spread.shape))

    @cached_property
    def _spread(self) -> FloatArray:
        """Standard deviation of the sum of white noise over each part of the angle, shape (groups, n_bins)."""
        count = [np.bincount(place, minlength=self.n_bins) for place in self.places]
        return np.asarray(np.sqrt(np.array(count, dtype=float)))

    def _of_sums(self, sums: FloatArray) -> FloatArray:
        spectrum = rfft(sums, axis=1)[:, self.first : self.first + len(self.orders)]
        samples = np.array([len(rows) for rows in self.groups])
        return np.asarray(2 * np.abs(spectrum) ** 2 / samples[:, None])


def prominence(power: FloatArray) -> FloatArray:
    """Tell how far an order stands out in all groups: sum of log(1 + power / median of the neighbours).

    What repeats in time, and not in angle, lies at other orders at other speeds and does not add up.

    Args:
        power: Order spectra, shape (groups, K), of at least `BACKGROUND` orders.

    Returns:
        Prominence [1], shape (K,).
    """
    count = power.shape[1]
    # blocks of neighbours, the last one as long as the others
    first = np.minimum(np.arange(0, count, BACKGROUND), count - BACKGROUND)
    medians = np.median(power[:, first[:, None] + np.arange(BACKGROUND)], axis=2)
    around = np.repeat(medians, BACKGROUND, axis=1)[:, :count]
    return np.asarray(np.log1p(power / np.maximum(around, 1e-300)).sum(axis=0))


def _groups(speed: FloatArray, moving: BoolArray) -> tuple[IntArray, ...]:
    """Divide moving samples by direction and by speed into groups of equal numbers."""
    found: list[IntArray] = []
    for sign in (1, -1):
        rows = np.flatnonzero(moving & (sign * speed > 0))
        count = min(SPEEDS, len(rows) // LEAST_SAMPLES)
        if count:
            by_speed = rows[np.argsort(np.abs(speed[rows]), kind="stable")]
            found += [np.sort(part) for part in np.array_split(by_speed, count)]
    return tuple(found)
