"""Innovations of a signal."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.where.views.innovations import innovations


def test_innovations_of_noise_are_the_noise() -> None:
    noise = np.random.default_rng(1).standard_normal(20000)
    found = innovations(noise)
    assert found.values.std() == pytest.approx(1.0, rel=0.02)
    assert found.noise_gain(np.ones(256)) == pytest.approx(1.0, abs=0.02)


def test_a_step_is_an_innovation_when_it_comes() -> None:
    signal = 50.0 * (np.arange(20000) // 5000 % 2) + np.random.default_rng(1).standard_normal(20000)
    size = np.abs(innovations(signal).values)
    assert size[5000] > 10 * np.median(size)
    assert size[5100:9900].max() < 0.5 * size[5000]


def test_silence_stays_silent() -> None:
    assert not innovations(np.zeros(1000)).values.any()
