"""Covariance of fitted numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.estimates import parameters_of
from flexros.gap.fit.least_squares import EXACTLY, chi2_of, fit, starts_of
from flexros.gap.fit.parameter_covariance import smoothed
from flexros.random_streams import generator
from tests.gap.diagnosis_logs import candidates_of, data_of, predictor_of

LEVEL = 0.03


def test_smoothed_white_periodogram_is_flat() -> None:
    power = generator(3, 900).exponential(size=20_000)
    flat = smoothed(power)
    assert flat.mean() == pytest.approx(1.0, abs=0.03)
    assert np.abs(flat[5_000:] - 1.0).max() < 0.15


def test_smoothing_keeps_a_step_at_low_frequency() -> None:
    power = np.where(np.arange(20_000) < 40, 0.01, 1.0)
    assert smoothed(power)[:30].max() < 0.1


def test_spread_of_estimates_is_as_stated() -> None:
    name = f"coulomb_friction@motor_1:level={LEVEL}"
    predictor = predictor_of(candidates_of(name)["coulomb_friction@motor_1"])
    off = []
    for seed in range(10, 18):
        data = data_of(name, seed=seed)
        starts = starts_of(predictor)
        best = starts[:, np.argmin(chi2_of(predictor, data, starts))]
        found = parameters_of(fit(predictor, data, best, 20, enough=EXACTLY), data)[0]["level"]
        off.append((found.value - LEVEL) / found.std)
    assert 0.5 < np.sqrt(np.mean(np.square(off))) < 1.8
