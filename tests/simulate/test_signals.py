"""Sensor noise has the stated spread and no memory."""

from __future__ import annotations

import numpy as np

from flexros.random_streams import Stream
from flexros.simulate.signals import white_noise

RMS = np.array([2e-6, 1e-4])


def test_noise_has_the_stated_rms_per_channel() -> None:
    noise = white_noise(RMS, 3, Stream.ENCODER).rows(0, 20_000)
    np.testing.assert_allclose(noise.std(axis=0), RMS, rtol=0.03)
    assert np.all(np.abs(noise.mean(axis=0)) < 4 * RMS / np.sqrt(20_000))


def test_noise_is_white_and_channels_are_independent() -> None:
    noise = white_noise(RMS, 3, Stream.ENCODER).rows(0, 20_000) / RMS
    correlations = [np.mean(noise[lag:, 0] * noise[: len(noise) - lag, 0]) for lag in range(1, 20)]
    assert np.max(np.abs(correlations)) < 4 / np.sqrt(20_000)
    assert abs(np.mean(noise[:, 0] * noise[:, 1])) < 4 / np.sqrt(20_000)


def test_streams_and_seeds_are_independent() -> None:
    first = white_noise(RMS, 3, Stream.ENCODER).rows(0, 100)
    for other in (white_noise(RMS, 4, Stream.ENCODER), white_noise(RMS, 3, Stream.TOOL)):
        assert not np.any(other.rows(0, 100) == first)


def test_same_seed_gives_the_same_noise() -> None:
    first, second = (white_noise(RMS, 3, Stream.TOOL).rows(5000, 10) for _ in range(2))
    assert np.array_equal(first, second)


def test_no_noise_where_the_sensor_is_perfect() -> None:
    assert not np.any(white_noise(np.zeros(2), 3, Stream.ENCODER).rows(0, 10))
