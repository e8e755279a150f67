"""The order of effects in an answer: those of a clear size first, and what closes most of the held-out gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from flexros.effects import effects as every_effect
from flexros.gap.schema import same_effect

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.gap.result import RankedCandidate
    from flexros.gap.schema import BudgetShare, Cause, Located, Waterfall

Ranked = TypeVar("Ranked", "Cause", "RankedCandidate")

CLEAR = 2.0
"""Size over its standard deviation from which an effect may come first [1] (chosen)."""
PLACES = 2
"""Decimals of shares and probabilities that decide the order (chosen)."""


def in_order(
    effects: Iterable[Ranked], budget: Sequence[BudgetShare], waterfall: Sequence[Waterfall]
) -> tuple[Ranked, ...]:
    """Sort effects by the share of the held-out gap that they close, those that close as much by probability.

    Before all come those of a clear size: a log that hardly shows how large another one is may have it stand for them.
    What closes is on the mean of added first and removed last, as in the waterfall. Effects of other explanations close
    nothing in this one.

    Args:
        effects: The effects; equal ones keep their order.
        budget: The gap divided among effects.
        waterfall: The same by joint, an effect at a time.
    """

    def key(one: Ranked) -> tuple[float, ...]:
        share = next((share for share in budget if same_effect(share, one)), None)
        mean, closed = (max(round(part, PLACES), 0.0) for part in (_mean(share), closed_by(one, waterfall)))
        place = 2 if mean == closed == 0 else int(not is_clear(one))
        return place, -mean, -closed, -round(one.probability, PLACES)

    return tuple(sorted(effects, key=key))


def is_clear(effect: Cause | RankedCandidate) -> bool:
    """Return whether the log determines any size of an effect to half of it: `CLEAR` standard deviations from zero."""
    kind = every_effect().get(effect.effect)
    shapes = {name for name in kind.ranges if kind.shaped_by(name)} if kind is not None else set()
    parameters = effect.parameters
    sizes = [one for name, one in parameters.items() if name not in shapes] or [*parameters.values()]
    return not sizes or any(one.determined and abs(one.value) >= CLEAR * one.std for one in sizes)


def _mean(share: BudgetShare | None) -> float:
    """Return the mean of the shares added first and removed last, as far as they are known [1]."""
    known = [] if share is None else [one for one in (share.share_first, share.share_last) if one is not None]
    return sum(known) / len(known) if known else 0.0


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


def largest_part(budget: Sequence[BudgetShare], causes: Sequence[Cause] = ()) -> tuple[BudgetShare | None, float]:
    """Return the effect that closes most of the gap whether it is added first or removed last, and at least how much.

    An effect that only makes up for others closes little in one of the two. None closes any where all do so. Those that
    close as much are compared on the mean of both; causes without a clear size do not count.

    Args:
        budget: The gap divided among effects.
        causes: The causes, with their sizes.
    """
    unclear = [cause for cause in causes if not is_clear(cause)]
    shares = [
        (one, min(one.share_first or 0.0, one.share_last or 0.0))
        for one in budget
        if one.effect is not None and not any(same_effect(one, cause) for cause in unclear)
    ]
    largest = max(shares, key=lambda pair: (round(pair[1], PLACES), _mean(pair[0])), default=None)
    return (None, 0.0) if largest is None or round(largest[1], PLACES) <= 0 else largest
