"""Views of the prediction errors: their contract, their discovery, and the locations that they report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.discovery import members
from flexros.gap.schema import Excess
from flexros.gap.where.significance import concentration

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Self

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.channel import Channel, ErrorSample
    from flexros.gap.where.prediction_errors import PredictionErrors


@dataclass(frozen=True)
class Location:
    """A location of the excess: a joint, frequency band and part of the motion.

    Attributes:
        signal: Signal, one of the `words` of its view.
        joint: Joint, or "tool".
        band_hz: Frequency band [Hz].
        regime: Part of the motion, e.g. "reversal" or "motor angle order 6.00".
        kind: Quantity that the regime is a part of, e.g. "speed", "torque", "time"; at most one location of each kind
            is reported per joint.
        share: Share of the whole excess of the signal [1].
        expected: Share that evenly spread excess would have here [1].
        p_value: Probability of such an excess without a gap, over all locations tested [1].
        least_share: Share from which the location is reported [1].
        mapped: Whether the maps of the report show the location, significant or not.
    """

    signal: str
    joint: str
    band_hz: tuple[float, float]
    regime: str
    kind: str
    share: float
    expected: float
    p_value: float
    least_share: float
    mapped: bool

    @property
    def score(self) -> float:
        """Concentration of the excess here [nats]."""
        return float(concentration(np.array([self.share]), np.array([self.expected]))[0])

    def excess(self) -> Excess:
        """Return the location as it is written into diagnosis.json."""
        low, high = self.band_hz
        return Excess(
            signal=self.signal,
            joint=self.joint,
            band_hz=(round(low, 3), round(high, 3)),
            regime=self.regime,
            share=self.share,
            p_value=self.p_value,
        )


class AbstractView(ABC):
    """A way to divide prediction errors among locations.

    How to add one: write one file in `flexros/gap/where/views` with one final subclass of `AbstractSimulatedView`,
    whose p-values come from simulated logs without a gap, or of `AbstractTestedView`, which computes its own. It is
    found by itself and provides

    1. `name`, and `rank`, its position among the views;
    2. `words`, the signals of its locations, each with the quantity that their shares refer to;
    3. the methods of its kind.
    """

    name: ClassVar[str]
    rank: ClassVar[int]
    """Views are evaluated in the order of their ranks, 1 first. One that draws random numbers of its own comes after
    those that draw none, so that it does not change their noise."""
    words: ClassVar[Mapping[str, str]]
    """Signals of the locations, and what a share of each is a share of in a sentence, e.g. "excess"."""


@dataclass(frozen=True, eq=False)
class Statistics:
    """Statistics of one sample of prediction errors at the P locations of a view.

    Attributes:
        power: Power over the level of the noise, shape (P,).
        score: Statistic that p-values are computed from, larger where there is more excess, shape (P,).
        total: Power that shares refer to, over the level of the noise.
    """

    power: FloatArray
    score: FloatArray
    total: float


@dataclass(frozen=True, eq=False)
class ViewExcess:
    """Excess of one channel at the locations of a view.

    Attributes:
        excess: Power less its mean in logs without a gap, over the level of the noise, shape (P,).
        p_value: Probability of such a score without a gap, over all locations tested [1], shape (P,).
        sized: Whether a location has enough samples, shape (P,).
        total: Excess of the channel, over the level of the noise.
        whole: Excess that shares refer to: the sum of `total` over all channels of the view where it is positive.
        n_channels: Number of these channels.
    """

    excess: FloatArray
    p_value: FloatArray
    sized: BoolArray
    total: float
    whole: float
    n_channels: int

    def share(self, excess: float) -> float:
        """Return the share of an excess in the whole [1]."""
        return float(np.clip(excess / self.whole, 0.0, 1.0)) if self.whole > 1e-300 else 0.0


@dataclass(frozen=True, eq=False)
class AbstractSimulatedView(AbstractView):
    """A view of one channel whose p-values come from simulated logs without a gap.

    Attributes:
        channel: The channel.
    """

    channel: Channel

    @classmethod
    @abstractmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Self]:
        """Prepare the view of each channel that it applies to.

        Args:
            errors: Prediction errors of the log. Views of the motors take `errors.motors`, so that they see the same
                simulated logs.
        """

    @property
    @abstractmethod
    def sized(self) -> BoolArray:
        """Whether each location has enough samples to be tested, shape (P,)."""

    @abstractmethod
    def statistics(self, sample: ErrorSample) -> Statistics:
        """Compute power and score of each location.

        Args:
            sample: Measured or simulated errors of the channel.
        """

    @abstractmethod
    def locations(self, found: ViewExcess) -> Iterator[Location]:
        """List the locations of the channel.

        Args:
            found: Excess and p-values, in the order of `statistics`.
        """


class AbstractTestedView(AbstractView):
    """A view that computes p-values of its own."""

    @classmethod
    @abstractmethod
    def of_log(cls, errors: PredictionErrors) -> Sequence[Location]:
        """List the locations of a log, with p-values corrected for the number of tests.

        Args:
            errors: Prediction errors of the log.
        """


@cache
def views() -> Sequence[type[AbstractView]]:
    """Find all views, by rank."""
    view_classes = members("flexros.gap.where.views", AbstractView)
    return sorted(view_classes.values(), key=lambda view: view.rank)
