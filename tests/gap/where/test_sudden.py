"""What earlier values do not foretell."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.where.sudden import sudden_part


def test_noise_is_sudden_throughout() -> None:
    noise = np.random.default_rng(1).standard_normal(20000)
    part = sudden_part(noise)
    assert part.values.std() == pytest.approx(1.0, rel=0.02)
    assert part.noise_gain(np.ones(256)) == pytest.approx(1.0, abs=0.02)


def test_a_step_is_sudden_when_it_comes() -> None:
    signal = 50.0 * (np.arange(20000) // 5000 % 2) + np.random.default_rng(1).standard_normal(20000)
    size = np.abs(sudden_part(signal).values)
    assert size[5000] > 10 * np.median(size)
    assert size[5100:9900].max() < 0.5 * size[5000]


def test_silence_stays_silent() -> None:
    assert not sudden_part(np.zeros(1000)).values.any()
