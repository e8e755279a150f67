"""Settings of the campaign of nulls with rounded encoders."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexros.random_streams import Stream
from flexros.validation.blind.plan import PlanSettings

SEED = 50_355_115
"""Seed of the cases; its stream is that of evaluation, which development does not draw from (chosen)."""


@dataclass(frozen=True)
class QuantizedNullsSettings:
    """Settings of the campaign.

    Attributes:
        seed: Seed of all cases.
        stream: Stream of random numbers.
        plan: How many cases there are, on which robots; all are nulls.
        wrong: Nominal model of those cases that have no exact one, of `NUISANCES`.
        encoder_steps: Smallest and largest step of the encoders over their noise [1].
        durations: Lengths of the logs to fit, to check on, and for neither, about [s].
    """

    seed: int = SEED
    stream: Stream = Stream.BLIND_EVALUATION
    plan: PlanSettings = field(
        default_factory=lambda: PlanSettings(
            robots={"four_mass_linear": 0.25, "four_mass": 0.25, "elbow": 0.2, "e12": 0.2, "rigid_six_axis": 0.1},
            per_size=0,
            nulls=400,
            unknowns=0,
            pairs=0,
            nuisance=0.5,
        )
    )
    wrong: str = "tolerance_3"
    encoder_steps: tuple[float, float] = (0.1, 1.0)
    durations: tuple[float, float, float] = (10.0, 5.0, 2.0)
