"""Drift of a slow motion."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.frf.estimate.drift import without_drift
from flexros.identify.frf.estimate.period_spectra import amplitudes

LINES = np.array([1, 3, 5, 7])


@pytest.mark.parametrize("n_periods", [2, 3])
def test_trend_is_taken_off_whatever_the_periodic_part_is(n_periods: int) -> None:
    rng = np.random.default_rng(0)
    periodic = np.tile(rng.standard_normal((200, 2)), (n_periods, 1))
    t = np.arange(200 * n_periods)[:, None] / 200
    steady = without_drift(periodic + 4.0 + 30.0 * t - 7.0 * t**2, n_periods, 2, LINES)
    change = (steady - periodic) - (steady - periodic).mean(axis=0)
    assert np.max(abs(change)) < 1e-11


def test_single_period_has_its_trend_removed_next_to_excited_lines() -> None:
    t = np.arange(200)[:, None] / 200
    periodic = sum(np.cos(2 * np.pi * line * t + line) for line in LINES)
    steady = without_drift(periodic + 4.0 + 30.0 * t, 1, 1, LINES)
    expected = [[np.exp(1j * line)] for line in LINES]
    np.testing.assert_allclose(amplitudes(steady, 1, LINES)[0], expected, atol=1e-12)


def test_degree_zero_leaves_the_samples() -> None:
    samples = np.arange(20.0)[:, None]
    assert without_drift(samples, 2, 0, LINES) is samples
