"""Settings of the study: measurements and fits."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StudySettings:
    """Settings of the study.

    Attributes:
        scenario: Built-in identification scenario: robot, excitation and controller.
        positions: Number of positions, chosen by the D-optimal design.
        candidates: Number of positions to choose from.
        blocks: Blocks of experiments in each position.
        starts: Random starts within a factor of 10, the same for all estimators.
        peers: The first of these starts, from which a general-purpose search starts as well; whole groups of ten.
        redrawn: Responses drawn anew for the empirical spread.
        seed: Seed of everything that is random.
    """

    scenario: str = "identify_six_axis"
    positions: int = 15
    candidates: int = 4000
    blocks: int = 2
    starts: int = 100
    peers: int = 30
    redrawn: int = 100
    seed: int = 1
