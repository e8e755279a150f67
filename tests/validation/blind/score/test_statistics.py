"""Intervals, calibration and detection curves against known figures."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.validation.blind.score.statistics import calibration, detection_curve, share


def test_interval_of_wilson() -> None:
    found = share([True] * 47 + [False])
    assert (found.hits, found.cases) == (47, 48)
    assert found.low == pytest.approx(0.891, abs=1e-3)
    assert found.high == pytest.approx(0.9963, abs=1e-3)


def test_share_of_no_cases_says_so() -> None:
    assert str(share([])) == "no cases"


def test_calibrated_probabilities_have_a_small_error() -> None:
    random = np.random.default_rng(1)
    stated = random.uniform(0, 1, 20_000)
    right = (random.uniform(size=20_000) < stated).astype(float)
    good, bad = calibration(stated, right), calibration(np.full(20_000, 0.99), right)
    assert good is not None
    assert bad is not None
    assert good.error < 0.02
    assert bad.error == pytest.approx(0.49, abs=0.01)
    assert good.count == (2000,) * 10
    assert good.log_loss == pytest.approx(0.5, abs=0.01)  # of an even distribution of probabilities


def test_detection_curve_finds_its_centre() -> None:
    random = np.random.default_rng(2)
    gain = np.exp(random.uniform(0, 8, 4000))
    found = (random.uniform(size=4000) < 1 / (1 + (30 / gain) ** 3)).astype(float)
    curve = detection_curve(gain, found)
    assert curve.centre == pytest.approx(30, rel=0.1)
    assert curve.at_90 == pytest.approx(30 * 9 ** (1 / 3), rel=0.15)


def test_detection_curve_of_what_was_always_found_has_no_centre() -> None:
    assert np.isnan(detection_curve(np.array([10.0, 100.0]), np.ones(2)).centre)
