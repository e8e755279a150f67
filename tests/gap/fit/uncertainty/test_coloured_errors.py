"""Spectra of errors, smoothed."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.uncertainty.coloured_errors import smoothed
from flexros.random_streams import generator

pytestmark = pytest.mark.slow


def test_smoothed_white_periodogram_is_flat() -> None:
    power = generator(3, 900).exponential(size=20_000)
    flat = smoothed(power)
    assert flat.mean() == pytest.approx(1.0, abs=0.03)
    assert np.abs(flat[5_000:] - 1.0).max() < 0.15


def test_smoothing_keeps_a_step_at_low_frequency() -> None:
    power = np.where(np.arange(20_000) < 40, 0.01, 1.0)
    assert smoothed(power)[:30].max() < 0.1
