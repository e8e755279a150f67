"""Settings of the campaign of crowds."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexros.random_streams import Stream
from flexros.validation.blind.plan import PlanSettings

SEED = 219_833_808
"""Seed of the cases; its stream is that of evaluation, which development does not draw from (chosen)."""


@dataclass(frozen=True)
class CrowdSettings:
    """Settings of the campaign.

    Attributes:
        seed: Seed of all cases.
        stream: Stream of random numbers.
        plan: How many cases there are, on which robots.
        durations: Lengths of the logs to fit, to check on, and for neither, about [s].
    """

    seed: int = SEED
    stream: Stream = Stream.BLIND_EVALUATION
    plan: PlanSettings = field(
        default_factory=lambda: PlanSettings(per_size=0, nulls=0, unknowns=0, pairs=0, crowds=60)
    )
    durations: tuple[float, float, float] = (20.0, 10.0, 8.0)
