"""Settings of a diagnosis, one group per step; all of them are recorded in the provenance of diagnosis.json."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class DiagnosisSettings(Settings):
    """Settings of a diagnosis."""

    level: float = Field(
        default=2e-4, gt=0, description="torque noise that the predictor allows for, relative: see `observer_gain` [1]"
    )
    fitted_share: float = Field(
        default=2 / 3, gt=0, lt=1, description="share of the log that is fitted to where there is no second one [1]"
    )
    threads: int = Field(default=0, ge=0, description="fits at the same time; 0: as many as there are cores")
    seed: int = Field(default=1, ge=0, description="seed of the simulated logs without gap")
    where: bool = Field(default=True, description="whether the locations of the gap are computed")
    next_experiment: bool = Field(
        default=True, description="whether an experiment is chosen where the answer is ambiguous"
    )
