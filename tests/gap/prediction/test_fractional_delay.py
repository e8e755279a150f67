"""Delays of fractions of a sample: exact motion of a mass, whole samples, constant torque."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.prediction.fractional_delay import delayed

STEP = 5e-4


def moved(pieces: list[tuple[float, float]]) -> tuple[float, float]:
    """Position and speed of a unit mass at rest after (torque, time) pieces."""
    position = speed = 0.0
    for torque, time in pieces:
        position += speed * time + 0.5 * torque * time**2
        speed += torque * time
    return position, speed


def smooth_torque(n: int = 4000) -> np.ndarray:
    t = np.arange(n) * STEP
    waves = (np.sin(2 * np.pi * f * t + k) for k, f in enumerate((3.0, 40.0, 170.0, 400.0)))
    return np.asarray(sum(waves) * np.minimum(t / 0.1, 1.0))[:, None]


@pytest.mark.parametrize("fraction", [0.2, 0.5, 0.9])
def test_a_mass_moves_as_under_the_torque_that_is_truly_delayed(fraction: float) -> None:
    torque = smooth_torque()[:, 0]
    before = np.concatenate([[torque[0]], torque[:-1]])
    position, speed = np.zeros(len(torque) + 1), 0.0
    for k, (old, new) in enumerate(zip(before, torque, strict=True)):
        x, v = moved([(old, fraction * STEP), (new, (1 - fraction) * STEP)])
        position[k + 1] = position[k] + speed * STEP + x
        speed += v
    held = delayed(torque[:, None], fraction, [0])[:, 0]
    mixed = (1 - fraction) * torque + fraction * before

    def error(given: np.ndarray) -> float:
        x, v = np.zeros(len(given) + 1), 0.0
        for k, value in enumerate(given):
            x[k + 1] = x[k] + v * STEP + 0.5 * value * STEP**2
            v += value * STEP
        second = np.diff(x - position, 2)  # forgets the start
        return float(np.std(second[1000:]))

    assert error(held) < 0.05 * error(mixed)


def test_whole_samples_shift() -> None:
    torque = smooth_torque(50)
    np.testing.assert_array_equal(delayed(torque, 3.0, [0])[3:], torque[:-3])
    np.testing.assert_array_equal(delayed(torque, 0.0, [0]), torque)


def test_a_constant_torque_stays() -> None:
    np.testing.assert_allclose(delayed(np.full((100, 1), 2.5), 1.7, [0]), 2.5, rtol=1e-12)


def test_other_motors_keep_their_torque() -> None:
    torque = np.hstack([smooth_torque(50), smooth_torque(50)])
    result = delayed(torque, 0.4, [1])
    np.testing.assert_array_equal(result[:, 0], torque[:, 0])
    assert np.max(np.abs(result[:, 1] - torque[:, 1])) > 0.0


@pytest.mark.parametrize("samples", [0.3, 1.0, 2.6])
def test_a_slow_torque_is_late_by_the_delay(samples: float) -> None:
    t = np.arange(8000)
    torque = np.sin(2 * np.pi * t / 2000)[:, None]
    expected = np.sin(2 * np.pi * (t - samples) / 2000)
    np.testing.assert_allclose(delayed(torque, samples, [0])[500:, 0], expected[500:], atol=1e-5)
