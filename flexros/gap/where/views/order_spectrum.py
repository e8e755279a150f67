"""Order spectrum: separates errors that repeat with the rotor angle from errors that repeat in time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.fft import next_fast_len, rfft

from flexros.gap.where.base import AbstractSimulatedView, Location, Statistics, ViewExcess

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Self

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.where.channel import ErrorSample
    from flexros.gap.where.prediction_errors import PredictionErrors

BINS_PER_PERIOD = 4
"""Angle bins in the shortest period (chosen)."""
LEAST_PERIODS = 3
"""Periods of the lowest order over the travel of the rotor (chosen)."""
BACKGROUND = 21
"""Neighbouring orders whose median is the background of a peak (chosen)."""
MOST_BINS = 2**17
"""Longest transform; with more bins, only lower orders are evaluated (chosen)."""
MOVING = 0.03
"""Share of the largest speed above which a rotor counts as turning (chosen)."""
SPEEDS = 3
"""Groups of similar speed in each direction (chosen)."""
LEAST_SAMPLES = 200
"""Samples that a group of similar speed needs (chosen)."""


@dataclass(frozen=True, eq=False)
class OrderSpectrum(AbstractSimulatedView):
    """Excess of the motor positions by order, P = K locations.

    Attributes:
        grid: Samples of the motor by rotor angle.
    """

    name: ClassVar[str] = "order_spectrum"
    rank: ClassVar[int] = 4
    words: ClassVar[Mapping[str, str]] = MappingProxyType({"position": "excess"})

    grid: OrderGrid

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each motor."""
        highest = errors.settings.orders
        return [
            cls(channel, OrderGrid.of(*channel.rotor, channel.valid, highest))
            for channel in errors.motors
            if channel.rotor is not None
        ]

    @property
    def sized(self) -> BoolArray:
        """Every order has enough samples."""
        return np.ones(len(self.grid.orders), dtype=bool)

    def statistics(self, sample: ErrorSample) -> Statistics:
        """Transform over the rotor angle; the spectrum of simulated noise is drawn, which is faster."""
        groups = self.grid.power(sample.values) if sample.random is None else self.grid.noise(sample.random)
        score = prominence(groups) if groups.size else np.zeros(groups.shape[1])
        return Statistics(groups.sum(axis=0) / sample.level, score, sample.total)

    def locations(self, found: ViewExcess) -> Iterator[Location]:
        """List the peaks, the most significant one for the map; their neighbours hold what leaks from them."""
        listed = [self._location(row, found) for row in self._peaks(found.excess)]
        if listed:
            best = min(listed, key=lambda location: (location.p_value, -location.share))
            yield from (replace(location, mapped=location is best) for location in listed)

    def _peaks(self, excess: FloatArray) -> Sequence[int]:
        inner = range(1, len(excess) - 1)
        return [row for row in inner if excess[row] == excess[row - 1 : row + 2].max()]

    def _location(self, row: int, found: ViewExcess) -> Location:
        channel, n_orders = self.channel, len(self.grid.orders)
        order = self.grid.peak_order(row, found.excess[row - 1 : row + 2])
        return Location(
            signal="position",
            joint=channel.joint,
            band_hz=channel.whole_band,
            regime=f"motor angle order {order:.2f}",
            kind="motor angle",
            share=found.share(float(found.excess[row])),
            expected=1 / n_orders / found.n_channels,
            p_value=float(found.p_value[row]),
            least_share=channel.settings.least_order_share,
            mapped=False,
        )


@dataclass(frozen=True, eq=False)
class OrderGrid:
    """Samples of a turning motor by rotor angle, in groups of equal direction and similar speed.

    Attributes:
        orders: Orders evaluated [periods per turn], shape (K,); empty where the rotor turns too little.
        first: Line of the first of them in a transform.
        n_bins: Number of angle bins.
        groups: Rows of the samples of each group.
        bins: Angle bin of each of these rows, by group.
    """

    orders: FloatArray
    first: int
    n_bins: int
    groups: tuple[IntArray, ...]
    bins: tuple[IntArray, ...]

    @classmethod
    def of(cls, angle: FloatArray, speed: FloatArray, valid: BoolArray, highest: float) -> OrderGrid:
        """Sort the samples of a motor into angle bins.

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
        bins = tuple(((angle[rows] - begin) / width).astype(np.int64) for rows in groups)
        return cls(orders[wanted], int(np.flatnonzero(wanted)[0]), n_bins, groups, bins)

    def power(self, values: FloatArray) -> FloatArray:
        """Compute the order spectrum of a signal in each group.

        Args:
            values: The signal, shape (n,).

        Returns:
            Sum of squares that a sinusoid of each order explains [square of the signal's unit], shape (groups, K).
        """
        if not self.groups:
            return np.zeros((0, len(self.orders)))
        sums = []
        for rows, bins in zip(self.groups, self.bins):
            inside = values[rows]
            sums.append(np.bincount(bins, weights=inside - inside.mean(), minlength=self.n_bins))
        return self._of_sums(np.array(sums, dtype=float).reshape(len(self.groups), self.n_bins))

    def peak_order(self, row: int, power: FloatArray) -> float:
        """Interpolate the order of a peak [periods per turn], by a parabola through the logarithms of power.

        Args:
            row: Row of the largest order of the peak.
            power: Power of the orders `row` - 1, `row` and `row` + 1, shape (3,).
        """
        low, middle, high = np.log(np.maximum(power, 1e-300))
        bend = low - 2 * middle + high
        shift = 0.5 * (low - high) / bend if bend < 0 else 0.0
        return float(self.orders[row] + np.clip(shift, -0.5, 0.5) * (self.orders[1] - self.orders[0]))

    def noise(self, random: np.random.Generator) -> FloatArray:
        """Draw the order spectrum of white noise of variance one, in the form of `power`."""
        if not self.groups:
            return np.zeros((0, len(self.orders)))
        return self._of_sums(self._spread * random.standard_normal(self._spread.shape))

    @cached_property
    def _spread(self) -> FloatArray:
        """Standard deviation of the sum of white noise over each angle bin, shape (groups, n_bins)."""
        count = [np.bincount(bins, minlength=self.n_bins) for bins in self.bins]
        return np.asarray(np.sqrt(np.array(count, dtype=float)))

    def _of_sums(self, sums: FloatArray) -> FloatArray:
        spectrum = rfft(sums, axis=1)[:, self.first : self.first + len(self.orders)]
        samples = np.array([len(rows) for rows in self.groups])
        return np.asarray(2 * np.abs(spectrum) ** 2 / samples[:, None])


def prominence(power: FloatArray) -> FloatArray:
    """Compute the prominence of each order: the sum over groups of log(1 + power / median of the neighbours).

    Errors that repeat in time, not in angle, have other orders at other speeds, so that their groups do not add up.

    Args:
        power: Order spectra, shape (groups, K), of at least `BACKGROUND` orders.

    Returns:
        Prominence [1], shape (K,).
    """
    count = power.shape[1]
    # blocks of neighbours, the last one as long as the others
    first = np.minimum(np.arange(0, count, BACKGROUND), count - BACKGROUND)
    medians = np.median(power[:, first[:, None] + np.arange(BACKGROUND)], axis=2)
    background = np.repeat(medians, BACKGROUND, axis=1)[:, :count]
    return np.asarray(np.log1p(power / np.maximum(background, 1e-300)).sum(axis=0))


def _groups(speed: FloatArray, moving: BoolArray) -> tuple[IntArray, ...]:
    """Divide moving samples by direction and speed into groups of equal size."""
    groups: list[IntArray] = []
    for sign in (1, -1):
        rows = np.flatnonzero(moving & (sign * speed > 0))
        count = min(SPEEDS, len(rows) // LEAST_SAMPLES)
        if count:
            by_speed = rows[np.argsort(np.abs(speed[rows]), kind="stable")]
            groups += [np.sort(part) for part in np.array_split(by_speed, count)]
    return tuple(groups)
