"""Colour of noise from stretches of which a trend was taken off."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from flexros.arrays import FloatArray
from flexros.gap.noise.autoregression import TREND, autoregressive_spectrum, colour_of, white_spectrum, without_trend

LENGTH, COUNT = 500, 40


def stretches(a: float) -> FloatArray:
    """Noise of variance 1 whose neighbours correlate by a, on parabolas."""
    random = np.random.default_rng(5)
    white = random.standard_normal(LENGTH * COUNT + 1000)
    noise = lfilter([np.sqrt(1 - a**2)], [1.0, -a], white)[1000:].reshape(COUNT, LENGTH)
    time = np.linspace(0, 1, LENGTH)
    return np.stack([without_trend(row + 50 * time**2 - 3 * time) for row in noise])


def test_a_parabola_is_taken_off() -> None:
    time = np.linspace(0, 1, LENGTH)
    np.testing.assert_allclose(without_trend(7 - 3 * time + 9 * time**2), 0, atol=1e-12)


def test_white_noise_has_no_colour_and_its_own_size() -> None:
    _, deviation, colour = colour_of(stretches(0.0))
    assert colour.size == 0
    assert deviation == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("a", [0.5, 0.9])
def test_what_the_trend_took_is_given_back(a: float) -> None:
    noise = stretches(a)
    _, deviation, colour = colour_of(noise)
    np.testing.assert_allclose(colour, [a], atol=0.02)
    assert deviation == pytest.approx(1.0, abs=0.04)
    if a == 0.9:
        assert np.sqrt(np.mean(noise**2)) < 0.96  # without what was given back
        assert TREND / LENGTH * (1 + a) / (1 - a) > 0.1


def test_the_simpler_noise_has_the_lower_criterion() -> None:
    noise = stretches(0.8)
    more = noise + 0.5 * np.stack([without_trend(np.sin(0.3 * np.arange(LENGTH) + k)) for k in range(COUNT)])
    assert colour_of(noise)[0] < colour_of(more)[0]


def test_autoregressive_noise_without_coefficients_is_white() -> None:
    assert autoregressive_spectrum(np.zeros((2, 3))) == pytest.approx(white_spectrum(3))


def test_positive_coefficient_is_low_frequency_noise() -> None:
    power = autoregressive_spectrum(np.array([[0.8]]))[:, 0]
    assert power[0] / power[-1] == pytest.approx((1.8 / 0.2) ** 2, rel=1e-3)


@pytest.mark.filterwarnings("error")
def test_a_slow_swing_that_no_autoregression_has_keeps_its_size() -> None:
    swing = np.sin(np.pi * np.linspace(0, 1, LENGTH)) ** 2 * np.sin(6 * np.pi * np.linspace(0, 1, LENGTH))
    _, deviation, _ = colour_of(np.stack([swing] * 3))
    assert deviation >= np.sqrt(np.mean(swing**2))
