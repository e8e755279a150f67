"""Levels of odd and even distortion and of time variation in closed loop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.estimate.distortion_levels import interpolated
from flexros.identify.frf.estimate.response_of import frequency_response_of
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.settings import FrfSettings

PERIOD, PERIODS, DROPPED, BLOCKS = 512, 4, 3, 3
ODD = np.arange(1, 60, 2)
LINES = np.delete(ODD, [4, 9, 14, 21, 25])


def levels(
    output: Callable[[np.ndarray], np.ndarray], noise: float = 0.0, gain: Callable[[int], float] = lambda k: 1.0
) -> Distortion:
    """Run x' = -x + u, y = output(x), u = 3 (r - y) by Euler's method and analyse it."""
    rng = np.random.default_rng(5)
    n, h = (DROPPED + PERIODS) * PERIOD, 0.1
    u, y = np.zeros((BLOCKS, n)), np.zeros((BLOCKS, n))
    for block in range(BLOCKS):
        phases = rng.uniform(0, 2 * np.pi, len(LINES))
        r = 0.3 * np.cos(2 * np.pi * np.outer(np.arange(n), LINES) / PERIOD + phases).sum(axis=1)
        disturbance, x = noise * rng.standard_normal(n), 0.0
        for k in range(n):
            y[block, k] = gain(k) * output(np.array(x)) + disturbance[k]
            u[block, k] = 3.0 * (r[k] - y[block, k])
            x += h * (u[block, k] - x)
    recorded = slice(DROPPED * PERIOD, None)
    mine = Experiments.of(u[:, recorded], y[:, recorded], 1e-3, n_periods=PERIODS, lines=LINES)
    found = frequency_response_of(mine, FrfSettings(drift_degree=0)).distortion
    assert found is not None
    return found


def rms(level: np.ndarray) -> float:
    return float(np.sqrt(np.mean(level**2)))


def test_linear_loop_has_no_distortion() -> None:
    found = levels(lambda x: x)
    assert max(rms(found.odd), rms(found.even), rms(found.total)) < 1e-8 * rms(found.output)


def test_cubic_output_shows_on_odd_lines_alone() -> None:
    found = levels(lambda x: x + 0.3 * x**3)
    assert rms(found.odd) > 0.01 * rms(found.output)
    assert rms(found.even) < 1e-6 * rms(found.odd)
    assert 0.2 < rms(found.odd) / rms(found.total) < 5  # the detection lines foretell the scatter over blocks


def test_square_output_shows_on_even_lines_alone_although_the_loop_feeds_it_back() -> None:
    """Of second order the output holds a x^2 with x = G u; harmonics of u at even lines are referred to the output."""
    found = levels(lambda x: x + 0.05 * x**2)
    assert rms(found.even) > 5 * rms(found.odd)
    assert rms(found.even) > 0.003 * rms(found.output)


def test_noise_is_told_from_distortion() -> None:
    found = levels(lambda x: x, noise=0.02)
    expected = 2 * 0.02 / np.sqrt(PERIOD) / np.sqrt(PERIODS)
    for level in (found.noise, found.total, found.odd, found.even, found.odd_noise, found.even_noise):
        assert 0.6 < rms(level) / expected < 1.5
    assert rms(found.time_variation) < 1.0 * rms(found.noise) * np.sqrt(PERIODS)


def test_changing_gain_is_time_variation() -> None:
    found = levels(lambda x: x, noise=0.001, gain=lambda k: 1.0 + 0.1 * (k // PERIOD) / PERIODS)
    assert rms(found.time_variation) > 20 * rms(found.noise[found.noise < np.inf] * 0 + rms(found.odd_noise))


def test_levels_follow_differentiation() -> None:
    found = levels(lambda x: x + 0.3 * x**3)
    twice = found.differentiated(2)
    np.testing.assert_allclose(twice.odd, found.odd * (2 * np.pi * found.odd_frequency[:, None]) ** 2)
    np.testing.assert_allclose(twice.output, found.output * (2 * np.pi * found.frequency[:, None]) ** 2)


def test_interpolation_is_linear_between_lines_and_holds_the_ends() -> None:
    response = np.array([1.0 + 1j, 3.0 - 1j]).reshape(2, 1, 1)
    found = interpolated(response, np.array([1.0, 3.0]), np.array([0.5, 2.0, 4.0]))[:, 0, 0]
    np.testing.assert_allclose(found, [1 + 1j, 2, 3 - 1j])
