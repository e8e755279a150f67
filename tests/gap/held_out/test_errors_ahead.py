"""Errors of predictions 0.1 s ahead: 1 without a gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import SignedErrors, errors_ahead
from tests.gap.diagnosis_logs import ROBOT, data_of, predictor_of
from tests.gap.held_out.made_errors import ahead, synthetic


@pytest.mark.slow
def test_without_gap_it_is_one() -> None:
    means = [ahead(seed=seed).mean for seed in (1, 2, 3)]
    # some 500 windows of 0.1 s in each log that overlap, four to an independent one
    assert np.mean(means) == pytest.approx(1.0, abs=4 * np.sqrt(2 / (3 * 500 / 4)))


def test_windows_lie_within_the_log_and_avoid_missing_samples() -> None:
    data = data_of()
    valid = data.record.valid.copy()
    valid[10_000:10_100] = False
    holed = replace(data, record=replace(data.record, valid=valid))
    found = errors_ahead(CandidateFit(predictor_of(), np.zeros(0), 0.0), holed)
    horizon = round(0.1 / ROBOT.sample_time)
    assert np.all(found.starts + horizon < data.record.n_samples)
    assert not np.any((found.starts < 10_100) & (found.starts + horizon >= 10_000))
    assert len(found.starts) == len(found.squares)


def test_errors_over_another_floor() -> None:
    found = synthetic(4.0).over(np.array([2e-4]))
    assert found.mean == pytest.approx(synthetic(4.0).mean / 4)
    assert found.floor[0] == 2e-4


def test_errors_of_a_diverged_prediction_are_limited() -> None:
    errors = SignedErrors(np.array([[np.inf], [-np.inf], [np.nan], [2.0]]), np.arange(4), np.ones(1))
    assert np.isfinite(errors.limited).all()
    assert errors.limited[3] == 2.0
    assert np.isfinite(errors.squares).all()
