"""Settings of the campaign of the blind check."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexros.random_streams import Stream
from flexros.validation.blind.plan import PlanSettings

SEED = 496_352_698
"""Seed of the cases; its stream is that of evaluation, which development does not draw from (chosen)."""


@dataclass(frozen=True)
class BlindSettings:
    """Settings of the campaign.

    Attributes:
        seed: Seed of all cases.
        plan: How many cases there are of what.
        durations: Lengths of the logs to fit, to check on, and for neither, about [s].
    """

    seed: int = SEED
    plan: PlanSettings = field(default_factory=PlanSettings)
    durations: tuple[float, float, float] = (20.0, 10.0, 8.0)

    @property
    def stream(self) -> Stream:
        """Stream of random numbers."""
        return Stream.BLIND_EVALUATION
