"""Settings of the study."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexros.validation.campaigns.linearisation.conditions import CONDITIONS, Condition
from flexros.validation.campaigns.linearisation.laws import LAWS
from flexros.validation.campaigns.linearisation.robots import ROBOTS, StudyRobot

TUNINGS = ("equal robustness", "equal bandwidth")
"""How the laws are tuned."""


@dataclass(frozen=True)
class LinearisationSettings:
    """Settings of the study.

    Attributes:
        robots: The robots.
        laws: Names of the laws.
        conditions: The conditions.
        tunings: Names of the tunings.
        draws: Number of plants of a random model error.
        repetitions: Number of noise seeds where the plant is known.
        seed: Seed of the plants, and first seed of the noise.
    """

    robots: tuple[StudyRobot, ...] = ROBOTS
    laws: tuple[str, ...] = tuple(law.name for law in LAWS)
    conditions: tuple[Condition, ...] = CONDITIONS
    tunings: tuple[str, ...] = TUNINGS
    draws: int = 24
    repetitions: int = 8
    seed: int = field(default=2007)
