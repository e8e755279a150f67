"""Spectrum of prediction errors without gap."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.where.floor import GRID, autoregressive, of_predictor, white
from tests.oracles.linear_gap import LinearLog


def test_spectrum_of_a_predictor_is_that_of_its_errors(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    errors = log.prediction.innovations[2000:]
    power = np.abs(np.fft.rfft(errors, axis=0)) ** 2 / len(errors) / log.prediction.sd**2
    lines = np.linspace(0, 1, len(power))
    shape = of_predictor(log.observer)
    grid = (np.arange(GRID) + 0.5) / GRID
    for low, high in ((0.0, 0.02), (0.02, 0.1), (0.5, 1.0)):
        found = power[(lines >= low) & (lines < high)].mean(axis=0)
        expected = shape[(grid >= low) & (grid < high)].mean(axis=0)
        assert found == pytest.approx(expected, rel=0.35)


def test_autoregressive_noise_without_coefficients_is_white() -> None:
    assert autoregressive(np.zeros((2, 3))) == pytest.approx(white(3))


def test_positive_coefficient_is_low_frequency_noise() -> None:
    power = autoregressive(np.array([[0.8]]))[:, 0]
    assert power[0] / power[-1] == pytest.approx((1.8 / 0.2) ** 2, rel=1e-3)
