"""Responses from whole periods of a simulated closed loop with encoder noise and slow motion."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.estimate.estimate_response import frequency_response_of
from flexros.identify.frf.estimate.periodic import periodic_response
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.frf.two_mass_example import TwoMassAxis

pytestmark = pytest.mark.slow

PERIOD, LINES, DROPPED, PERIODS, BLOCKS = 1000, np.arange(1, 41, 2), 9, 2, 2
SLOW_SPEED = 0.05
"""Speed of the motion under the excitation [rad/s]."""


@pytest.fixture(scope="module")
def axis() -> TwoMassAxis:
    return TwoMassAxis.builtin()


def record(axis: TwoMassAxis, runs: int, noise: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torques, positions and references, shape (runs, BLOCKS, PERIODS PERIOD)."""
    rng = np.random.default_rng(seed)
    t = np.arange((DROPPED + PERIODS) * PERIOD)
    parts = []
    for _ in range(BLOCKS):
        phases = rng.uniform(0, 2 * np.pi, len(LINES))
        r = 0.3 * np.cos(2 * np.pi * np.outer(t, LINES) / PERIOD + phases).sum(axis=1)
        u, y = axis.closed_loop(r + SLOW_SPEED, noise * rng.standard_normal((len(t), runs)))
        reference = np.broadcast_to(r[:, None], u.shape)
        parts.append([signal[DROPPED * PERIOD :].T for signal in (u, y, reference)])
    return tuple(np.array([part[i] for part in parts]).swapaxes(0, 1) for i in range(3))  # type: ignore[return-value]


def true_position_response(axis: TwoMassAxis, frequency: np.ndarray) -> np.ndarray:
    return np.asarray(axis.sampled_speed_response(frequency) / (2j * np.pi * frequency))


def test_errors_of_the_estimate_are_as_large_as_claimed(axis: TwoMassAxis) -> None:
    """Encoder noise goes through the controller into the torque; 120 repetitions of 20 lines."""
    runs = 120
    u, y, r = record(axis, runs, 2e-5, 1)
    errors, totals, noises = [], [], []
    for i in range(runs):
        experiments = Experiments.of(u[i], y[i], axis.sample_time, reference=r[i], n_periods=PERIODS, lines=LINES)
        result = frequency_response_of(experiments)
        errors.append(abs(result.response[:, 0, 0] - true_position_response(axis, result.frequency)) ** 2)
        totals.append(result.standard_deviation("total")[:, 0, 0] ** 2)
        noises.append(result.standard_deviation("noise")[:, 0, 0] ** 2)
    error, total, noise = (np.mean(part, axis=0) for part in (errors, totals, noises))
    assert abs(np.mean(error / total) - 1) < 0.07
    assert abs(np.mean(error / noise) - 1) < 0.07


@pytest.mark.parametrize("average", ["joint", "arithmetic", "logarithmic"])
@pytest.mark.parametrize("reference", ["auto", "unknown"])
def test_estimate_without_noise_is_the_sampled_model(axis: TwoMassAxis, average: str, reference: str) -> None:
    u, y, r = record(axis, 1, 0.0, 2)
    experiments = Experiments.of(u[0], y[0], axis.sample_time, reference=r[0], n_periods=PERIODS, lines=LINES)
    result = frequency_response_of(
        experiments, FrfSettings.model_validate({"average": average, "reference": reference})
    )
    truth = true_position_response(axis, result.frequency)
    np.testing.assert_allclose(result.response[:, 0, 0], truth, rtol=2e-3)


def test_slow_motion_spoils_the_estimate_unless_its_drift_is_taken_off(axis: TwoMassAxis) -> None:
    u, y, r = record(axis, 1, 0.0, 2)
    experiments = Experiments.of(u[0], y[0], axis.sample_time, reference=r[0], n_periods=PERIODS, lines=LINES)
    truth = true_position_response(axis, experiments.frequency)

    def worst(degree: int) -> float:
        result = periodic_response(experiments, FrfSettings(drift_degree=degree)).response[:, 0, 0]
        return float(np.max(abs(result / truth - 1)))

    assert worst(1) < 2e-3
    assert worst(0) > 0.5
    with pytest.raises(InputError, match="is below its standard deviation"):
        frequency_response_of(experiments, FrfSettings(drift_degree=0))


def test_single_period_and_block_give_a_response_without_covariance(axis: TwoMassAxis) -> None:
    u, y, _ = record(axis, 1, 0.0, 3)
    experiments = Experiments.of(u[0, :1, :PERIOD], y[0, :1, :PERIOD], axis.sample_time, lines=LINES)
    result = frequency_response_of(experiments)
    np.testing.assert_allclose(result.response[:, 0, 0], true_position_response(axis, result.frequency), rtol=1e-2)
    assert result.total_error is None
    assert result.noise_error is None
