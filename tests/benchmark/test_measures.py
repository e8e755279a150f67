"""Measures of runs that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.benchmark.disturbances import static_torque
from flexros.benchmark.measures import Measures, mean, measures_of_run, oscillation, worst

T = 5e-4
N = 64001


def test_settling_time_of_an_exponential() -> None:
    time = np.arange(N) * T
    deflection = np.where(time >= 6.0, np.exp(-(time - 6.0) / 0.4), 0.0)
    found = measures_of_run(deflection, static_torque(N, T), 0.1, T)
    assert found.settling[1] == pytest.approx(0.4 * np.log(10.0), abs=2 * T)
    assert found.deflection[1] == pytest.approx(1.0, abs=1e-4)
    assert found.settling[2] == 0.0


def test_static_torque_of_the_steps_does_not_count() -> None:
    command = static_torque(N, T)
    assert command[round(3 / T)] == -8.0
    assert command[round(7 / T)] == -2.0
    assert command[round(20 / T)] == 6.0
    assert command[round(25 / T)] == 0.0
    found = measures_of_run(np.zeros(N), command, 0.1, T)
    assert found.rms_torque == 0.0
    assert found.largest_torque == 8.0


def test_torque_at_rest_counts_as_noise() -> None:
    command = np.zeros(N)
    command[2000], command[2001], command[100] = 0.5, -0.25, 9.0
    assert measures_of_run(np.zeros(N), command, 0.1, T).noise_torque == 0.75


def test_diverged_run_costs_infinitely() -> None:
    deflection = np.zeros(N)
    deflection[-1] = np.nan
    assert measures_of_run(deflection, np.zeros(N), 0.1, T).cost == np.inf


def test_cost_weights_amplitudes_and_times() -> None:
    found = Measures(np.full(8, 1.0), np.full(4, 1.0), 1.0, 1.0, 1.0)
    assert found.cost == pytest.approx(11 * 1.259 + 4 * 3.477)


def test_worst_and_mean_are_taken_measure_by_measure() -> None:
    first = Measures(np.arange(8.0), np.zeros(4), 1.0, 5.0, 0.0)
    second = Measures(np.arange(8.0)[::-1], np.ones(4), 2.0, 3.0, 0.0)
    assert worst([first, second]).deflection.tolist() == [7, 6, 5, 4, 4, 5, 6, 7]
    assert (worst([first, second]).noise_torque, worst([first, second]).largest_torque) == (2.0, 5.0)
    assert mean([first, second]).deflection.tolist() == [3.5] * 8


def test_drift_is_no_oscillation() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    assert oscillation(3.0 * time) == pytest.approx(0.0, abs=1e-12)
    assert oscillation(3.0 * time + 0.01 * np.sin(100.0 * time)) == pytest.approx(0.02, rel=0.1)
