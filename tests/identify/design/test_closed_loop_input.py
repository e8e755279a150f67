"""Predicted torque spectrum: the loop against a simulation, orthogonality, errors."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import control_law
from flexros.control.context import LoopContext
from flexros.identify.design.closed_loop_input import ExperimentConditions, input_spectrum, output_error
from flexros.identify.experiment.closed_loop_response import ControllerResponse, controller_response
from flexros.robot import load_robot

T = 5e-4


def test_torques_are_those_of_a_simulated_loop() -> None:
    """A mass under PD in steady state: torque amplitude of one line against a simulation sample by sample."""
    mass, line, n = 2.0, 5, 400
    law = control_law({"kind": "pid", "kp": 8e4, "kd": 300.0})
    frequency = np.array([line / (n * T)])
    z = np.exp(2j * np.pi * frequency * T)
    sampled = T**2 / 2 * (z + 1) / (z - 1) ** 2 / mass  # held force on a mass, exactly
    response = ((2j * np.pi * frequency) ** 2 * sampled)[:, None, None]
    conditions = ExperimentConditions(frequency, np.array([[0.3]]), np.zeros(1))
    predicted = input_spectrum(
        response, conditions, controller_response(law, LoopContext(load_robot("two_mass"), T), frequency)
    )[0, 0, 0]

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
    controller = ControllerResponse(np.concatenate([none, unit], axis=2), none)
    spectrum = input_spectrum(none, conditions, controller)[0]
    assert spectrum @ spectrum.conj().T == pytest.approx(3 * np.diag([1.0, 4.0, 9.0]))


def test_error_is_encoder_noise_and_a_share_of_the_output() -> None:
    frequency = np.array([1.0, 10.0])
    response, spectrum = np.ones((2, 1, 1)) * 3.0, np.ones((2, 1, 1)) * 2.0
    quiet = ExperimentConditions(frequency, np.ones((2, 1)), np.array([1e-8]))
    noise = (2 * np.pi * frequency) ** 4 * 1e-8
    assert output_error(response, spectrum, quiet)[:, 0] == pytest.approx(noise)
    loud = ExperimentConditions(frequency, np.ones((2, 1)), np.array([1e-8]), distortion=0.1)
    assert output_error(response, spectrum, loud)[:, 0] == pytest.approx(noise + 0.01 * 36)
