"""Predicted torque spectrum: controller responses against their formulas, the loop against a simulation."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import control_law
from flexros.identify.design.closed_loop_input import (
    ExperimentConditions,
    controller_response,
    input_spectrum,
    output_error,
)

T = 5e-4
FREQUENCY = np.array([0.5, 3.0, 40.0, 300.0])


def test_pid_has_its_formula() -> None:
    law = control_law({"kind": "pid", "kp": [3.0, 5.0], "ki": 7.0, "kd": 0.2, "derivative_filter": 1e-3})
    reference, feedback = controller_response(law, 2, T, FREQUENCY)
    back = np.exp(-2j * np.pi * FREQUENCY * T)
    for motor, kp in enumerate([3.0, 5.0]):
        expected = kp + 7.0 * T / (1 - back) + 0.2 * (1 - back) / (1e-3 + T - 1e-3 * back)
        assert reference[:, motor, motor] == pytest.approx(expected)
        assert feedback[:, motor, motor] == pytest.approx(-expected)
    assert np.all(reference[:, 0, [1, 2, 3, 5]] == 0)
    assert reference[:, 0, 4] == pytest.approx(np.ones(4))  # feedforward torque


def test_cascade_follows_the_speed_reference() -> None:
    settings = {
        "kind": "cascade",
        "position_gain": 4.0,
        "speed_gain": 30.0,
        "integral_gain": 50.0,
        "speed_filter": 2e-3,
    }
    reference, feedback = controller_response(control_law(settings), 1, T, FREQUENCY)
    back = np.exp(-2j * np.pi * FREQUENCY * T)
    integral = 30.0 + 50.0 * T / (1 - back)
    assert reference[:, 0, 1] == pytest.approx(integral)
    assert reference[:, 0, 0] == pytest.approx(4.0 * integral)
    speed = (1 - back) / (2e-3 + T - 2e-3 * back)
    assert feedback[:, 0, 0] == pytest.approx(-integral * (4.0 + speed))


def test_torques_are_those_of_a_simulated_loop() -> None:
    """A mass under PD in steady state: torque amplitude of one line against a simulation sample by sample."""
    mass, line, n = 2.0, 5, 400
    law = control_law({"kind": "pid", "kp": 8e4, "kd": 300.0})
    frequency = np.array([line / (n * T)])
    z = np.exp(2j * np.pi * frequency * T)
    sampled = T**2 / 2 * (z + 1) / (z - 1) ** 2 / mass  # held force on a mass, exactly
    response = ((2j * np.pi * frequency) ** 2 * sampled)[:, None, None]
    conditions = ExperimentConditions(frequency, np.array([[0.3]]), np.zeros(1))
    predicted = input_spectrum(response, conditions, *controller_response(law, 1, T, frequency))[0, 0, 0]

    time = np.arange(20 * n) * T
    position_reference = 0.3 / (2 * np.pi * frequency) * np.sin(2 * np.pi * frequency * time)
    x, v, error_before, torque = 0.0, 0.0, 0.0, np.zeros(len(time))
    for k, reference in enumerate(position_reference):
        error = reference - x
        torque[k] = 8e4 * error + 300.0 * (error - error_before) / T
        error_before = error
        x, v = x + T * v + T**2 / 2 * torque[k] / mass, v + T * torque[k] / mass
    measured = 2 * np.mean(torque[-n:] * np.exp(-2j * np.pi * frequency * time[-n:]))
    assert predicted == pytest.approx(measured, rel=1e-6)


def test_multisines_of_a_block_are_orthogonal() -> None:
    conditions = ExperimentConditions(np.array([2.0]), np.array([[1.0, 2.0, 3.0]]), np.zeros(3))
    none, unit = np.zeros((1, 3, 3)), np.eye(3)[None]
    gain = np.concatenate([none, unit, none], axis=2)
    spectrum = input_spectrum(none, conditions, gain, none)[0]
    assert spectrum @ spectrum.conj().T == pytest.approx(3 * np.diag([1.0, 4.0, 9.0]))


def test_error_is_encoder_noise_and_a_share_of_the_output() -> None:
    frequency = np.array([1.0, 10.0])
    response, spectrum = np.ones((2, 1, 1)) * 3.0, np.ones((2, 1, 1)) * 2.0
    quiet = ExperimentConditions(frequency, np.ones((2, 1)), np.array([1e-8]))
    noise = (2 * np.pi * frequency) ** 4 * 1e-8
    assert output_error(response, spectrum, quiet)[:, 0] == pytest.approx(noise)
    loud = ExperimentConditions(frequency, np.ones((2, 1)), np.array([1e-8]), distortion=0.1)
    assert output_error(response, spectrum, loud)[:, 0] == pytest.approx(noise + 0.01 * 36)
