"""Smooth motion, and noise of high differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from flexros.record.smoothing import noise_power, smooth_motion

T = 1e-3
TIME = T * np.arange(4000)


def test_slow_motion_passes_with_its_derivatives() -> None:
    w = 2 * np.pi * 2.0
    motion = smooth_motion(np.sin(w * TIME)[:, None], T, 40.0)[:, 500:-500, 0]
    inside = TIME[500:-500]
    expected = [np.sin(w * inside), w * np.cos(w * inside), -(w**2) * np.sin(w * inside)]
    for found, wanted in zip(motion, expected, strict=True):
        np.testing.assert_allclose(found, wanted, atol=2e-3 * np.abs(wanted).max())


def test_fast_motion_is_taken_off() -> None:
    found = smooth_motion(np.sin(2 * np.pi * 300 * TIME)[:, None], T, 40.0)[0, 500:-500]
    assert np.abs(found).max() < 1e-3


def test_noise_is_seen_under_slow_motion() -> None:
    rng = np.random.default_rng(0)
    position = np.column_stack([np.sin(2 * np.pi * TIME), np.zeros(len(TIME))])
    noisy = position + rng.normal(size=position.shape) * [1e-3, 1e-5]
    assert np.sqrt(noise_power(noisy)) == pytest.approx([1e-3, 1e-5], rel=0.15)


@pytest.mark.parametrize("n", [16, 17, 500])
@pytest.mark.parametrize("cutoff", [2.0, 20.0, 100.0])
def test_positions_are_filtered_as_scipy_does(n: int, cutoff: float) -> None:
    position = np.random.default_rng(n).normal(size=(n, 2)).cumsum(axis=0)
    expected = sosfiltfilt(butter(4, 2 * cutoff * T, output="sos"), position, axis=0)
    np.testing.assert_allclose(smooth_motion(position, T, cutoff)[0], expected, rtol=1e-12, atol=1e-12)


def test_too_few_positions_are_refused_as_scipy_does() -> None:
    with pytest.raises(ValueError, match="15 values are too few, at least 16 are needed"):
        smooth_motion(np.zeros((15, 1)), T, 20.0)
