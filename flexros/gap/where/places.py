"""All places of all signals, with their shares of the excess."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.where.regimes import FAMILIES
from flexros.gap.where.score import concentration

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.channel import Channel, Look

POSITION, SUDDEN, TOOL = "position", "sudden position change", "tool"
"""Names of the signals: prediction errors of motors, what earlier ones of them do not foretell, and the tool's."""


@dataclass(frozen=True)
class FoundPlace:
    """A place with what is needed to choose among all of them.

    Attributes:
        signal: `POSITION`, `SUDDEN` or `TOOL`.
        joint: Joint, or "tool".
        band_hz: Frequency band [Hz].
        regime: Part of the motion, or e.g. "motor angle order 6.00".
        family: What it is a part of: "all", "speed", "torque", "time", "motor angle", ...
        bands: Number of octave bands; 0 for all of them.
        share: Share of the whole excess of the signal [1].
        expected: Share that an even spread would put there [1].
        p_value: Over all places [1].
    """

    signal: str
    joint: str
    band_hz: tuple[float, float]
    regime: str
    family: str
    bands: int
    share: float
    expected: float
    p_value: float

    @property
    def score(self) -> float:
        """How much the excess is concentrated here [nats]."""
        return float(concentration(np.array([self.share]), np.array([self.expected]))[0])


@dataclass(frozen=True, eq=False)
class Seen:
    """A signal with the excess and p-value of its places; arrays as of `Look`.

    Attributes:
        channel: The signal.
        excess: Power over that of noise, in units of the noise's variance, by run of bands and regime, (n_ranges, R).
        sudden: The same of the sudden part, shape (R,).
        orders: The same by order, shape (K,).
        p: p-values by run of bands and regime, shape (n_ranges, R).
        p_sudden: p-values of the sudden part, shape (R,).
        p_orders: p-values by order, shape (K,).
        sized: Whether places of bands and regimes are large enough, shape (n_ranges, R).
    """

    channel: Channel
    excess: FloatArray
    sudden: FloatArray
    orders: FloatArray
    p: FloatArray
    p_sudden: FloatArray
    p_orders: FloatArray
    sized: BoolArray

    @classmethod
    def of(
        cls,
        channel: Channel,
        look: Look,
        excess: FloatArray,
        sudden: FloatArray,
        orders: FloatArray,
        p_value: FloatArray,
        sized: BoolArray,
    ) -> Seen:
        """Take the p-values of all statistics apart; arguments as above, p-values in the order of the statistics."""
        count, regime_count = look.bands.size, len(look.sudden)
        return cls(
            channel=channel,
            excess=excess,
            sudden=sudden,
            orders=orders,
            p=p_value[:count].reshape(look.bands.shape),
            p_sudden=p_value[count : count + regime_count],
            p_orders=p_value[count + regime_count :],
            sized=sized[:count].reshape(look.bands.shape),
        )

    @property
    def full(self) -> int:
        """Number of the run of all bands."""
        return len(self.excess) - 1


def places_of(seen: Sequence[Seen]) -> tuple[FoundPlace, ...]:
    """List the places of all signals.

    Args:
        seen: The signals.
    """
    motors = [one for one in seen if one.channel.joint != TOOL]
    axes = [one for one in seen if one.channel.joint == TOOL]
    found: list[FoundPlace] = []
    for signal, group in ((POSITION, motors), (TOOL, axes)):
        whole = _whole([one.excess[one.full, 0] for one in group])
        for one in group:
            found += _in_bands(one, signal, whole, len(motors) if signal == POSITION else len(axes))
    sudden = _whole([one.sudden[0] for one in motors])
    whole = _whole([one.excess[one.full, 0] for one in motors])
    for one in motors:
        found += _in_regimes(one, sudden, len(motors))
        found += _at_orders(one, whole, len(motors))
    return tuple(found)


def _whole(parts: Sequence[float]) -> float:
    return max(float(sum(max(part, 0.0) for part in parts)), 1e-300)


def _share(excess: float, whole: float) -> float:
    return float(np.clip(excess / whole, 0.0, 1.0)) if whole > 1e-300 else 0.0


def _expected(excess: float, whole: float, time: float, regime: int, even: float) -> float:
    """Return what an even spread puts into a place: over joints and octaves, or in a regime over the time."""
    return float(even) if regime == 0 else _share(excess, whole) * float(time)


def _in_bands(one: Seen, signal: str, whole: float, signals: int) -> Iterator[FoundPlace]:
    bands = one.channel.bands
    time = one.channel.time_share
    count = len(bands.lengths)
    for run, (first, last) in enumerate(bands.ranges):
        for place, regime in enumerate(one.channel.regimes):
            if one.sized[run, place]:
                yield FoundPlace(
                    signal=signal,
                    joint=one.channel.joint,
                    band_hz=(float(bands.hz[first]), float(bands.hz[last])),
                    regime=regime,
                    family=FAMILIES[regime],
                    bands=0 if last - first == count else int(last - first),
                    share=_share(one.excess[run, place], whole),
                    expected=_expected(one.excess[run, 0], whole, time[place], place, (last - first) / count / signals),
                    p_value=float(one.p[run, place]),
                )


def _in_regimes(one: Seen, whole: float, signals: int) -> Iterator[FoundPlace]:
    for place, regime in enumerate(one.channel.regimes):
        if one.channel.time_share[place] > 0:
            yield FoundPlace(
                signal=SUDDEN,
                joint=one.channel.joint,
                band_hz=_all(one),
                regime=regime,
                family=FAMILIES[regime],
                bands=0,
                share=_share(one.sudden[place], whole),
                expected=float(one.channel.time_share[place] / signals),
                p_value=float(one.p_sudden[place]),
            )


def _at_orders(one: Seen, whole: float, signals: int) -> Iterator[FoundPlace]:
    """Give the orders that stand out of their neighbours; beside a peak lies what leaks from it."""
    grid, p = one.channel.orders, one.p_orders
    for place in range(1, len(p) - 1):
        assert grid is not None
        beside = one.orders[place - 1 : place + 2]
        if one.orders[place] == beside.max():
            yield FoundPlace(
                signal=POSITION,
                joint=one.channel.joint,
                band_hz=_all(one),
                regime=f"motor angle order {grid.between(place, beside):.2f}",
                family="motor angle",
                bands=0,
                share=_share(float(one.orders[place]), whole),
                expected=1 / len(p) / signals,
                p_value=float(p[place]),
            )


def _all(one: Seen) -> tuple[float, float]:
    return 0.0, float(one.channel.bands.hz[-1])
