"""Smooth motion, and noise of high differences."""

from __future__ import annotations

import numpy as np
import pytest

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
