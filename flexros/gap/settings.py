"""Settings of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisSettings:
    """Settings of a diagnosis.

    Attributes:
        level: Torque noise that the predictor allows for, see `observer_gain` [1].
        fitted_share: Share of the log that is fitted to where there is no second one [1].
        threads: Fits at the same time; 0: as many as there are cores.
        seed: Seed of the simulated logs without gap.
        where: Whether the places of the gap are looked for.
        next_experiment: Whether an experiment is chosen where the answer is ambiguous.
    """

    level: float = 2e-4
    fitted_share: float = 2 / 3
    threads: int = 0
    seed: int = 1
    where: bool = True
    next_experiment: bool = True
