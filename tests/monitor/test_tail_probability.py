"""Tails against the chi-square distribution, an integral and random numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from flexros.monitor.tail_probability import log_tail, threshold, weights_of_mean_square


@pytest.mark.parametrize("samples", [20, 200, 20000])
@pytest.mark.parametrize("probability", [1e-2, 1e-5, 1e-10])
def test_white_noise_has_the_chi_square_distribution(samples: int, probability: float) -> None:
    weights, times = weights_of_mean_square(np.array([1.0]), samples)
    found = threshold(weights, times, probability)
    assert chi2.sf(found * samples, samples) == pytest.approx(probability, rel=0.05)


def test_two_unequal_weights_have_the_exact_distribution() -> None:
    """P(a x1 + a x2 + b x3 + b x4 > t) of two pairs is that of two exponentials."""
    a, b = 0.4, 0.1
    t = 9.0
    exact = (a * np.exp(-t / (2 * a)) - b * np.exp(-t / (2 * b))) / (a - b)
    assert np.exp(log_tail(np.array([a, b]), 2.0, t)) == pytest.approx(exact, rel=0.1)


def test_coloured_noise_exceeds_its_level_as_often_as_said() -> None:
    rng = np.random.default_rng(3)
    pole, samples = 0.8, 60
    white = rng.normal(size=(40_000, samples + 100))
    signal = np.empty_like(white)
    signal[:, 0] = white[:, 0]
    for k in range(1, white.shape[1]):
        signal[:, k] = pole * signal[:, k - 1] + np.sqrt(1 - pole**2) * white[:, k]
    weights, times = weights_of_mean_square(pole ** np.arange(400), samples)
    level = threshold(weights, times, 0.01)
    exceeded = np.mean(np.mean(signal[:, 100:] ** 2, axis=1) > level)
    assert exceeded == pytest.approx(0.01, abs=0.002)


def test_long_windows_are_described_by_their_spectrum() -> None:
    covariance = 0.9 ** np.arange(200)
    short = threshold(*weights_of_mean_square(covariance, 256), 1e-4)
    long = threshold(*weights_of_mean_square(covariance, 257), 1e-4)
    assert long == pytest.approx(short, rel=0.03)
