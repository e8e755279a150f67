"""Predictions of one sample are worse by more than chance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from flexros.gap.held_out.one_sample import surely_worse
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import MODEL, record_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData


@dataclass(frozen=True)
class Left:
    """A fit that leaves given errors one sample ahead."""

    errors: FloatArray

    def residual(self, _: FitData) -> FloatArray:
        return self.errors.copy()


def test_predictions_of_one_sample_are_worse_only_where_they_are_by_more_than_chance() -> None:
    """An eccentricity stayed that a third of the gap 0.1 s ahead came from: in one second of the log it helped."""
    held = fit_data(record_of(seed=2), MODEL, DiagnosisSettings())
    errors = np.ones(held.record.position.size)
    in_one_second = errors.copy()
    in_one_second[: round(1 / held.record.sample_time)] = 1.5
    more, once = Left(1.01 * errors), Left(in_one_second)
    same = Left(errors)
    assert surely_worse(cast("CandidateFit", more), cast("CandidateFit", same), held)
    assert not surely_worse(cast("CandidateFit", once), cast("CandidateFit", same), held)
