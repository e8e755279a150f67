"""Levels of odd and even distortion and of time variation in closed loop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.estimate.distortion_levels import interpolated
from flexros.identify.frf.estimate.estimate_response import frequency_response_of
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
    experiments = Experiments.of(u[:, recorded], y[:, recorded], 1e-3, n_periods=PERIODS, lines=LINES)
    distortion = frequency_response_of(experiments, FrfSettings(drift_degree=0)).distortion
    assert distortion is not None
    return distortion


def rms(level: np.ndarray) -> float:
    return float(np.sqrt(np.mean(level**2)))


def test_linear_loop_has_no_distortion() -> None:
    distortion = levels(lambda x: x)
    assert max(rms(distortion.odd), rms(distortion.even), rms(distortion.total)) < 1e-8 * rms(distortion.output)


def test_cubic_output_shows_on_odd_lines_alone() -> None:
    distortion = levels(lambda x: x + 0.3 * x**3)
    assert rms(distortion.odd) > 0.01 * rms(distortion.output)
    assert rms(distortion.even) < 1e-6 * rms(distortion.odd)
    assert 0.2 < rms(distortion.odd) / rms(distortion.total) < 5  # the detection lines foretell the scatter over blocks


def test_square_output_shows_on_even_lines_alone_although_the_loop_feeds_it_back() -> None:
    """Of second order the output holds a x^2 with x = G u; harmonics of u at even lines are referred to the output."""
    distortion = levels(lambda x: x + 0.05 * x**2)
    assert rms(distortion.even) > 5 * rms(distortion.odd)
    assert rms(distortion.even) > 0.003 * rms(distortion.output)


def test_noise_and_distortion_are_separated() -> None:
    distortion = levels(lambda x: x, noise=0.02)
    expected = 2 * 0.02 / np.sqrt(PERIOD) / np.sqrt(PERIODS)
    for level in (
        distortion.noise,
        distortion.total,
        distortion.odd,
        distortion.even,
        distortion.odd_noise,
        distortion.even_noise,
    ):
        assert 0.6 < rms(level) / expected < 1.5
    assert rms(distortion.time_variation) < 1.0 * rms(distortion.noise) * np.sqrt(PERIODS)


def test_changing_gain_is_time_variation() -> None:
    distortion = levels(lambda x: x, noise=0.001, gain=lambda k: 1.0 + 0.1 * (k // PERIOD) / PERIODS)
    assert rms(distortion.time_variation) > 20 * rms(
        distortion.noise[distortion.noise < np.inf] * 0 + rms(distortion.odd_noise)
    )


def test_levels_follow_differentiation() -> None:
    distortion = levels(lambda x: x + 0.3 * x**3)
    twice = distortion.differentiated(2)
    np.testing.assert_allclose(twice.odd, distortion.odd * (2 * np.pi * distortion.odd_frequency[:, None]) ** 2)
    np.testing.assert_allclose(twice.output, distortion.output * (2 * np.pi * distortion.frequency[:, None]) ** 2)


def test_interpolation_is_linear_between_lines_and_holds_the_ends() -> None:
    response = np.array([1.0 + 1j, 3.0 - 1j]).reshape(2, 1, 1)
    distortion = interpolated(response, np.array([1.0, 3.0]), np.array([0.5, 2.0, 4.0]))[:, 0, 0]
    np.testing.assert_allclose(distortion, [1 + 1j, 2, 3 - 1j])
