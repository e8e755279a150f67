"""Power by octave."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.fft import rfft

from flexros.gap.where.bands import OctaveBands, fast_length_within


def test_power_of_all_bands_is_that_of_the_signal() -> None:
    signal = np.random.default_rng(1).standard_normal(4000)
    bands = OctaveBands.of(4000, 1e-3, 2.0)
    assert sum(one.sum() for one in bands.power(rfft(signal))) == pytest.approx((signal**2).sum(), rel=2e-3)


def test_a_burst_is_found_in_its_band_and_time() -> None:
    time = 1e-3 * np.arange(4000)
    signal = np.sin(2 * np.pi * 90 * time) * ((time > 1) & (time < 1.5))
    bands = OctaveBands.of(4000, 1e-3, 2.0)
    mask = ((time > 0.95) & (time < 1.55)).astype(float)
    weights = bands.weights(mask[None])
    power = bands.power(rfft(signal))
    place = int(np.searchsorted(bands.hz, 90)) - 1
    assert power[place].sum() > 0.9 * (signal**2).sum()
    assert weights[place][:, 0] @ power[place] > 0.9 * power[place].sum()


def test_level_is_that_of_the_noise_in_spite_of_rare_bursts() -> None:
    signal = 3.0 * np.random.default_rng(1).standard_normal(8000)
    signal[1000:1100] += 100 * np.random.default_rng(2).standard_normal(100)
    bands = OctaveBands.of(8000, 1e-3, 2.0)
    level = bands.level(bands.power(rfft(signal)), np.ones(len(bands.lengths)))
    assert level == pytest.approx(9.0, rel=0.2)  # the mean square is 134


def test_bands_join_and_reach_the_nyquist_frequency() -> None:
    bands = OctaveBands.of(5000, 1e-3, 2.0)
    assert bands.hz[0] == 0
    assert bands.hz[-1] == 500
    assert bands.hz[1] >= 2
    assert len(bands.ranges) == len(bands.lengths) * (len(bands.lengths) + 1) // 2


def test_fast_length_is_near_and_not_above() -> None:
    assert fast_length_within(7919) <= 7919
    assert fast_length_within(7919) > 7500
