"""All settings of a diagnosis."""

from __future__ import annotations

import os

from pydantic import Field

from flexros.config.settings import Settings
from flexros.gap.settings.answer import (
    NextExperimentSettings,
    PredictionGapSettings,
    RankingSettings,
    SensitivitySettings,
)
from flexros.gap.settings.log import NoiseSettings, ResidualSettings, RigidArmSettings, WhereSettings
from flexros.gap.settings.search import BristleSettings, FitSettings, SearchSettings
from flexros.gap.settings.start import ServoStartSettings, TorqueStartSettings


class DiagnosisSettings(Settings):
    """Settings of a diagnosis."""

    level: float = Field(
        default=2e-4, gt=0, description="torque noise that the predictor allows for, relative: see `observer_gain` [1]"
    )
    fitted_share: float = Field(
        default=2 / 3, gt=0, lt=1, description="share of the log that is fitted to where there is no second one [1]"
    )
    most_values: int = Field(
        default=400_000,
        ge=1000,
        description="most samples of all motors together that are fitted or held out; of a longer log the most "
        "informative part, so that memory stays below 1.5 GB",
    )
    values_per_second: float = Field(
        default=5000,
        gt=0,
        description="the same for each second of a time limit, from `least_values` on, so that a search comes to its "
        "end within the limit and the answer soon after it (chosen: a search takes 1 s for 3000 to 7000 of them)",
    )
    least_values: int = Field(
        default=50_000, ge=1000, description="samples of all motors together that no time limit leaves out"
    )
    rigid_arm: RigidArmSettings = Field(
        default=RigidArmSettings(), description="how much is taken of the log of an arm without springs"
    )
    time_limit: float | None = Field(
        default=None,
        gt=0,
        description="time from the begin of the diagnosis in which an answer must be found [s]: after four fifths of "
        "it the search ends, and the best explanation so far is checked on the held-out log; nothing: none",
    )
    threads: int = Field(default=0, ge=0, description="fits at the same time; 0: as many as there are cores")
    seed: int = Field(default=1, ge=0, description="seed of the simulated logs without gap")
    noise: NoiseSettings = Field(default=NoiseSettings(), description="encoder noise")
    residuals: ResidualSettings = Field(default=ResidualSettings(), description="weighted prediction errors")
    where: WhereSettings | None = Field(
        default=WhereSettings(), description="locations of the gap; nothing: they are not computed"
    )
    prediction_gap: PredictionGapSettings = Field(default=PredictionGapSettings(), description="gap on held-out data")
    sensitivity: SensitivitySettings | None = Field(
        default=SensitivitySettings(),
        description="names with halved and doubled tolerances, for logs of real machines; nothing: not compared",
    )
    next_experiment: NextExperimentSettings | None = Field(
        default=NextExperimentSettings(),
        description="experiment that is proposed where the answer is ambiguous; nothing: none is",
    )
    fit: FitSettings = Field(default=FitSettings(), description="least-squares fit of one hypothesis")
    torque_start: TorqueStartSettings = Field(
        default=TorqueStartSettings(), description="what the torques of a real machine show before the search"
    )
    servo_start: ServoStartSettings = Field(
        default=ServoStartSettings(), description="fits of servos under position commands before the search"
    )
    search: SearchSettings = Field(default=SearchSettings(), description="which hypotheses are fitted")
    bristles: BristleSettings = Field(default=BristleSettings(), description="bristles of dry friction")
    ranking: RankingSettings = Field(default=RankingSettings(), description="probabilities and verdict")

    @property
    def cores(self) -> int:
        """Threads that work at the same time."""
        return self.threads or os.cpu_count() or 1
