"""Excess of the motor positions by octave band and regime."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.where.base import AbstractSimulatedView, Location, Statistics, ViewExcess
from flexros.gap.where.regimes import REGIMES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Self

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.channel import ErrorSample
    from flexros.gap.where.prediction_errors import PredictionErrors


class AbstractBands(AbstractSimulatedView):
    """Power of a channel in every run of neighbouring octave bands and every regime.

    Arrays over locations have the shape (n_ranges, R), flattened.
    """

    @property
    def signal(self) -> str:
        """Signal of the locations."""
        (signal,) = self.words
        return signal

    @property
    def sized(self) -> BoolArray:
        """Whether each location has enough degrees of freedom."""
        freedom = 2 * np.array([weights.sum(axis=0) for weights in self.channel.weights])
        return self._runs(freedom).ravel() >= self.channel.settings.least_freedom

    def statistics(self, sample: ErrorSample) -> Statistics:
        """Sum the power over bands; cube roots of powers are nearly normal (Wilson & Hilferty 1931)."""
        power = self._runs(sample.band_power).ravel()
        return Statistics(power, np.cbrt(power), sample.total)

    def locations(self, found: ViewExcess) -> Iterator[Location]:
        """List the locations with enough samples."""
        channel, bands = self.channel, self.channel.bands
        n_bands, time_share = len(bands.lengths), channel.time_share
        shape = len(bands.ranges), len(channel.regimes)
        excess, p_value, sized = (array.reshape(shape) for array in (found.excess, found.p_value, found.sized))
        for run, column in zip(*np.nonzero(sized)):
            first, end = bands.ranges[run]
            width, regime = int(end - first), channel.regimes[column]
            # evenly spread excess: over joints and octaves, and that of a band over time
            even = width / n_bands / found.n_channels
            expected = even if column == 0 else found.share(excess[run, 0]) * float(time_share[column])
            yield Location(
                signal=self.signal,
                joint=channel.joint,
                band_hz=(float(bands.hz[first]), float(bands.hz[end])),
                regime=regime,
                kind=REGIMES[regime].kind,
                share=found.share(excess[run, column]),
                expected=expected,
                p_value=float(p_value[run, column]),
                least_share=channel.settings.least_share,
                mapped=width == 1 < n_bands if regime == "all" else width == n_bands,
            )

    def _runs(self, per_band: FloatArray) -> FloatArray:
        """Sum over every run of bands, shape (n_ranges, R)."""
        total = np.concatenate([np.zeros((1, per_band.shape[1])), np.cumsum(per_band, axis=0)])
        ranges = self.channel.bands.ranges
        return np.asarray(total[ranges[:, 1]] - total[ranges[:, 0]])


class PositionBands(AbstractBands):
    """Excess of the motor positions by octave band and regime."""

    name: ClassVar[str] = "position_bands"
    rank: ClassVar[int] = 1
    words: ClassVar[Mapping[str, str]] = MappingProxyType({"position": "excess"})

    @classmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each motor."""
        return [cls(channel) for channel in errors.motors]
