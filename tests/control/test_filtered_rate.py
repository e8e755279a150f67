"""Rates by filtered differences, and gains that change while a law runs."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.filtered_rate import FilteredRate
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

T = 1e-3


def rates(signal: np.ndarray, filter_time: float) -> np.ndarray:
    state, y = casadi.SX.sym("c", FilteredRate.size(1)), casadi.SX.sym("y")
    found = FilteredRate(state, y, filter_time, T)
    step = casadi.Function("step", [state, y], [found.rate, found.after])
    memory, values = np.zeros(3), []
    for value in signal:
        rate, after = step(memory, value)
        memory = after.full().ravel()
        values.append(float(rate))
    return np.array(values)


def test_without_filter_it_is_the_difference() -> None:
    signal = np.random.default_rng(2).standard_normal(20)
    assert rates(signal, 0.0) == pytest.approx(np.concatenate([[0.0], np.diff(signal) / T]), rel=1e-9)


def test_a_ramp_is_reached_with_the_time_constant() -> None:
    found = rates(5.0 * T * np.arange(200), 0.01)
    assert found[0] == 0.0
    assert found[10] == pytest.approx(5.0 * (1 - (0.01 / 0.011) ** 10), rel=1e-9)
    assert found[-1] == pytest.approx(5.0, rel=1e-6)


ENDINGS = (".bandwidth", ".kp", ".loop_gain", ".speed_gain", ".motor_position", "D.1.1")
"""Endings of the names of one gain of each law."""
LAWS = (
    "circle_pd",
    "two_mass_step",
    "four_mass_state_space",
    "four_mass_lqg",
    "elbow_gravity_pd",
    "elbow_computed_torque",
    "elbow_feedback_linearisation",
    "elbow_quasi_static",
    "elbow_state_feedback",
    "elbow_kalman",
    "elbow_extended_kalman",
    "elbow_accelerometer",
    "elbow_torque_feedback",
)


@pytest.mark.parametrize("name", LAWS)
def test_gains_change_from_the_next_sample_on(name: str) -> None:
    run = Experiment.prepare(load_scenario(name).with_values({"duration": 0.1}))
    loops = [(run.plant_in_time(), run.controller()) for _ in range(2)]
    gain = next(i for i, key in enumerate(loops[0][1].gain_names) if key.endswith(ENDINGS))
    changed = []
    for k, reference in enumerate(run.reference_signal[:100]):
        if k == 50:
            gains = loops[1][1].gains
            gains[gain] *= 1.3
            loops[1][1].gains = gains
        commands = []
        for plant, controller in loops:
            commands.append(controller.step([*plant.measure(), *plant.further()], reference))
            plant.advance(commands[-1])
        changed.append(not np.array_equal(*commands))
    assert not any(changed[:50])
    assert all(changed[50:])
