"""The order of effects in an answer: what closes most of the held-out gap first, equal ones by probability."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from flexros.gap.schema import same_effect

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.gap.result import RankedCandidate
    from flexros.gap.schema import BudgetShare, Cause, Located, Waterfall

Ranked = TypeVar("Ranked", "Cause", "RankedCandidate")

PLACES = 2
"""Decimals of shares and probabilities that decide the order (chosen)."""


def in_order(
    effects: Iterable[Ranked], budget: Sequence[BudgetShare], waterfall: Sequence[Waterfall]
) -> tuple[Ranked, ...]:
    """Sort effects by the share of the held-out gap that they close, those that close as much by probability.

    Those of other explanations close nothing in this one.

    Args:
        effects: The effects; equal ones keep their order.
        budget: The gap divided among effects.
        waterfall: The same by joint, an effect at a time.
    """

    def key(one: Ranked) -> tuple[float, float, float]:
        opened, closed = shares_of(one, budget, waterfall)
        return -max(opened, 0.0), -max(closed, 0.0), -round(one.probability, PLACES)

    return tuple(sorted(effects, key=key))


def shares_of(effect: Located, budget: Sequence[BudgetShare], waterfall: Sequence[Waterfall]) -> tuple[float, float]:
    """Return the share of the gap that opens without an effect, and the share that it closes in the waterfall [1].

    Args:
        effect: The effect.
        budget: The gap divided among effects.
        waterfall: The same by joint, an effect at a time.
    """
    opened = next((one.share_last for one in budget if same_effect(one, effect)), None)
    return round(opened or 0.0, PLACES), round(closed_by(effect, waterfall), PLACES)


def closed_by(effect: Located, waterfall: Sequence[Waterfall]) -> float:
    """Return the share of the gap of all joints that an effect closes in the waterfall [1]; 0 where it is not there."""
    steps = (step for one in waterfall for step in one.steps)
    return sum(step.share for step in steps if same_effect(step, effect))


def largest_part(budget: Sequence[BudgetShare]) -> tuple[BudgetShare | None, float]:
    """Return the effect that closes most of the gap whether it is added first or removed last, and at least how much.

    An effect that only makes up for others closes little in one of the two. None closes any where all do so.

    Args:
        budget: The gap divided among effects.
    """
    shares = ((one, min(one.share_first or 0.0, one.share_last or 0.0)) for one in budget if one.effect is not None)
    largest = max(shares, key=lambda pair: pair[1], default=None)
    return (None, 0.0) if largest is None or round(largest[1], PLACES) <= 0 else largest
