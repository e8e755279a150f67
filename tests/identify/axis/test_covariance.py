"""Covariance of a least-squares estimate."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.axis.covariance import prediction_covariance


@pytest.fixture(name="slopes")
def fixture_slopes() -> np.ndarray:
    return np.random.default_rng(1).normal(size=(4000, 3)) * [1.0, 1e3, 1e-4]


def test_white_errors_give_the_usual_covariance(slopes: np.ndarray) -> None:
    errors = 0.1 * np.random.default_rng(2).normal(size=4000)
    expected = 0.01 * np.linalg.inv(slopes.T @ slopes)
    covariance = prediction_covariance(errors, slopes, 5)
    assert np.sqrt(np.diag(covariance)) == pytest.approx(np.sqrt(np.diag(expected)), rel=0.05)


def test_correlated_errors_and_slopes_raise_deviations(slopes: np.ndarray) -> None:
    slow = np.repeat(slopes[::20], 20, axis=0)
    errors = np.repeat(0.1 * np.random.default_rng(3).normal(size=200), 20)
    usual = 0.01 * np.linalg.inv(slow.T @ slow)
    ratio = np.sqrt(np.diag(prediction_covariance(errors, slow, 60)) / np.diag(usual))
    assert np.all((ratio > 3) & (ratio < 6))  # sqrt(20), less the Bartlett weights


def test_intervals_of_short_records_hold() -> None:
    """A mean of 300 samples, correlated over 20 of them, covered by its 95 % interval."""
    rng, ones = np.random.default_rng(4), np.ones((300, 1))
    noise = np.stack([np.convolve(rng.normal(size=340), np.hanning(21), "valid")[:300] for _ in range(1500)])
    means = noise.mean(axis=1)
    covered = [
        abs(mean) < 1.96 * np.sqrt(prediction_covariance(row - mean, ones, 30)[0, 0])
        for row, mean in zip(noise, means, strict=True)
    ]
    assert np.mean(covered) > 0.92


def test_parameters_that_act_alike_are_not_identifiable(slopes: np.ndarray) -> None:
    errors = 0.1 * np.random.default_rng(2).normal(size=4000)
    alike = np.column_stack([slopes, -7.0 * slopes[:, 1]])
    covariance = prediction_covariance(errors, alike, 5)
    assert np.all(np.isinf(np.diag(covariance)[[1, 3]]))
    alone = prediction_covariance(errors, slopes, 5)
    assert np.diag(covariance)[[0, 2]] == pytest.approx(np.diag(alone)[[0, 2]], rel=0.02)


def test_parameter_without_effect_is_not_identifiable(slopes: np.ndarray) -> None:
    errors = 0.1 * np.random.default_rng(2).normal(size=4000)
    covariance = prediction_covariance(errors, np.column_stack([slopes, np.zeros(4000)]), 5)
    assert np.isinf(covariance[3, 3])
    assert np.all(np.isfinite(covariance[:3, :3]))
