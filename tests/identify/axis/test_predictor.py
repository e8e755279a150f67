"""The predictor: sensitivities against differences, simulation against the plant, observer that forgets."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.axis import AxisStructure
from flexros.identify.axis.predictor import Predictor
from flexros.identify.axis.record import AxisRecord
from flexros.simulate.plant import Plant
from tests.identify.axis.recorded_axis import EFFECTS, TRUTH, axis_of, recorded_axis, three_mass

pytestmark = pytest.mark.slow

LOG = recorded_axis(samples=600)
RICH = {"stribeck_friction": 6.0, "stribeck_speed": 0.3, "offset": 2.0, "gear_doubling": 0.01}
THREE = {"arm_1_inertia": 4.0, "arm_2_inertia": 2.0, "arm_stiffness": 5e4, "arm_damping": 20.0}


def record(structure: AxisStructure, delay: float = 0.0) -> AxisRecord:
    return axis_of(LOG, structure.output, delay)


def values(structure: AxisStructure) -> np.ndarray:  # type: ignore[type-arg]
    known = TRUTH | RICH | (THREE if structure.masses == 3 else {})
    return np.array([known[name] for name in structure.names])


@pytest.mark.parametrize(
    "structure",
    [
        AxisStructure(),
        AxisStructure(output="velocity", gear="cubic", offset=True),
        AxisStructure(masses=3, gear="linear", stribeck=True),
    ],
    ids=["two", "velocity", "three"],
)
def test_sensitivities_are_the_derivatives_of_the_errors(structure: AxisStructure) -> None:
    given, theta = record(structure, delay=0.0004), values(structure)
    predictor = Predictor(structure, given, 0.1, 2)
    gain = predictor.gain(theta, 1e5, 1.0)
    errors, slopes = predictor.sensitivities(given, theta, gain)
    np.testing.assert_allclose(predictor.errors(given, theta, gain), errors, atol=1e-15)
    for place, value in enumerate(theta):
        step = np.zeros_like(theta)
        step[place] = 1e-5 * value
        high, low = (predictor.errors(given, theta + sign * step, gain) for sign in (1, -1))
        difference = (high - low) / (2e-5 * value)
        size = np.max(np.abs(slopes[:, place]))
        np.testing.assert_allclose(slopes[:, place], difference, rtol=0, atol=2e-3 * size)


def test_without_correction_the_predictor_is_the_simulated_robot() -> None:
    robot = three_mass()
    plant = Plant(robot, 1e-3, np.zeros(6))
    command = 50 * np.random.default_rng(1).standard_normal(300)
    position = np.zeros(300)
    for k, torque in enumerate(command):
        position[k] = plant.measure()[0]
        plant.advance([torque])
    given = AxisRecord("it", "position", 1e-3, command, position, 0.0)
    structure = AxisStructure(masses=3, gear="linear")
    theta = values(structure) * [name not in ("viscous_friction", "coulomb_friction") for name in structure.names]
    states = Predictor(structure, given, 1.0, 1).states(given, theta, np.zeros(structure.n_states))
    np.testing.assert_allclose(states[:, 0], position, atol=1e-12)


@pytest.mark.parametrize("structure", [AxisStructure(), AxisStructure(output="velocity")], ids=["position", "velocity"])
def test_observer_forgets_a_wrong_start_as_fast_as_it_says(structure: AxisStructure) -> None:
    given, theta = record(structure), values(structure)
    predictor = Predictor(structure, given, 0.02, 1)
    gain = predictor.gain(theta, 1e5, 1.0)
    wrong = AxisRecord("it", given.quantity, given.sample_time, given.torque, given.output.copy(), 0.0)
    wrong.output[0] += 0.1
    difference = np.abs(predictor.errors(wrong, theta, gain) - predictor.errors(given, theta, gain))
    memory = predictor.memory(theta, gain, 1.0)
    assert memory < 500
    assert np.max(difference[memory + 20 :]) < 3e-3 * np.max(difference)


def test_more_output_noise_lowers_the_gain() -> None:
    structure = AxisStructure()
    predictor, theta = Predictor(structure, record(structure), 0.02, 1), values(structure)
    gains = [np.linalg.norm(predictor.gain(theta, ratio, 1.0)) for ratio in (1e3, 1e5, 1e7)]
    assert gains[0] < gains[1] < gains[2]


def test_errors_at_the_truth_are_the_noise_of_the_record() -> None:
    assert EFFECTS
    structure = AxisStructure()
    given = axis_of(recorded_axis(torque_noise=0.0, samples=3000))
    predictor, theta = Predictor(structure, given, 0.02, 1), values(structure)
    gain = predictor.gain(theta, 3e4, 1.0)
    assert np.std(predictor.errors(given, theta, gain)[200:]) == pytest.approx(1e-5, rel=0.15)
