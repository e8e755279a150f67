"""Settings of a diagnosis, one group per step; all of them are recorded in the provenance of diagnosis.json."""

from flexros.gap.settings.answer import (
    NextExperimentSettings,
    PredictionGapSettings,
    RankingSettings,
    SensitivitySettings,
)
from flexros.gap.settings.diagnosis import DiagnosisSettings
from flexros.gap.settings.log import NoiseSettings, ResidualSettings, WhereSettings
from flexros.gap.settings.search import BristleSettings, FitSettings, SearchSettings
from flexros.gap.settings.start import ServoStartSettings, TorqueStartSettings

__all__ = [
    "BristleSettings",
    "DiagnosisSettings",
    "FitSettings",
    "NextExperimentSettings",
    "NoiseSettings",
    "PredictionGapSettings",
    "RankingSettings",
    "ResidualSettings",
    "SearchSettings",
    "SensitivitySettings",
    "ServoStartSettings",
    "TorqueStartSettings",
    "WhereSettings",
]
