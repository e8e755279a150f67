"""Noise of further sensors and the spectrum of their errors."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.residuals.sensor_noise import error_spectrum, variance_error, white_noise
from flexros.prediction.observer import observer_gain
from tests.gap.diagnosis_logs import ROBOT

N = 20_000


def test_noise_is_found_beside_motion() -> None:
    random = np.random.default_rng(0)
    noise = 1e-3 * random.standard_normal(N)
    motion = np.sin(2 * np.pi * 3 * np.arange(N) * 1e-3)
    found = white_noise(noise + motion, noise + motion)
    assert found == pytest.approx(1e-3, rel=3 * variance_error(N) / 2)


def test_impacts_are_no_noise() -> None:
    noise = 1e-3 * np.random.default_rng(1).standard_normal(N)
    noise[::500] += 1.0
    assert white_noise(noise, noise) == pytest.approx(1e-3, rel=0.05)


def test_rounding_is_noise() -> None:
    values = 0.01 * np.round(np.sin(np.arange(N) * 1e-3) / 0.01)
    assert white_noise(np.zeros(N), values) == pytest.approx(0.01 / np.sqrt(12), rel=1e-6)


@pytest.mark.parametrize("tolerated", [None, np.array([0.5])])
def test_the_mean_of_the_spectrum_is_the_variance(tolerated: np.ndarray | None) -> None:
    gain = observer_gain(ROBOT, ROBOT.sample_time, 0.01, ROBOT.encoder_noise, tolerated=tolerated)
    readout = np.zeros(len(gain.error))
    readout[0] = 1.0
    turns = (np.arange(200_000) + 0.5) / 400_000
    spectrum = error_spectrum(gain, readout, 1e-5, 1, turns)
    assert spectrum.mean() == pytest.approx(gain.error[0, 0] + 1e-10, rel=1e-3)
    assert spectrum[0] > 10 * spectrum[-1]


def test_a_sensor_that_does_not_see_the_state_is_white() -> None:
    gain = observer_gain(ROBOT, ROBOT.sample_time, 0.01, ROBOT.encoder_noise)
    spectrum = error_spectrum(gain, np.zeros(len(gain.error)), 2.0, 3, np.linspace(0, 0.5, 7))
    np.testing.assert_allclose(spectrum, 4.0)
