"""Predicted information: conditions of an experiment, and agreement with the matrices that a fit would use."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import control_law
from flexros.control.context import LoopContext
from flexros.identify.design.closed_loop_input import input_spectrum
from flexros.identify.design.position_information import (
    experiment_conditions,
    frequency_information,
    position_information,
)
from flexros.identify.excitation.multisine import Multisine
from flexros.identify.experiment.closed_loop_response import controller_response
from flexros.identify.experiment.specification import IdentificationSpecification
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot import load_robot
from flexros.robot.linear.positions import linearise_positions

ROBOT = load_robot("e12")
NAMES = ("body_1.ry.stiffness", "body_1.ry.damping", "body_2.ry.stiffness", "body_3.ry.stiffness")
LAW = control_law({"kind": "pid", "kp": 135000, "kd": 9000})
POSITIONS = np.array([[0.0, 0.3], [0.2, 1.0], [0.0, -0.8]])


def specification(**settings: object) -> IdentificationSpecification:
    return IdentificationSpecification(positions=((0.0, 0.3),), excitation=Multisine(**settings), periods=3)


def test_conditions_are_those_of_the_excitation() -> None:
    wanted = specification(period=2.0, lowest=1.0, highest=31.0, amplitude=[0.02, 0.05])
    conditions = experiment_conditions(wanted, ROBOT, 5e-4, seed=1)
    lines = wanted.excitation.lines(5e-4, 1).excited
    assert conditions.frequency == pytest.approx(lines / 2.0)
    assert np.sqrt(np.sum(conditions.amplitude**2, axis=0) / 2) == pytest.approx([0.02, 0.05])
    assert conditions.encoder_variance == pytest.approx(4 * (2e-6) ** 2 / (4000 * 3))
    assert conditions.share == 1.0


def test_few_lines_stand_for_all() -> None:
    wanted = specification(period=2.0, lowest=1.0, highest=61.0)
    few = experiment_conditions(wanted, ROBOT, 5e-4, 1, most_lines=12)
    all_lines = wanted.excitation.lines(5e-4, 1).excited
    assert len(few.frequency) == 12
    assert few.share == pytest.approx(len(all_lines) / 12)
    assert few.frequency[[0, -1]] == pytest.approx(all_lines[[0, -1]] / 2)


def test_information_is_that_of_the_covariance_of_the_responses() -> None:
    """Against 2 Re Psi^H Lambda^-1 Psi with the whole covariance matrix of vec(G), line by line."""
    conditions = experiment_conditions(specification(), ROBOT, 5e-4, 1, most_lines=10)
    found = position_information(ROBOT, NAMES, POSITIONS, conditions, LAW, 5e-4)
    linear = linearise_positions(ROBOT, NAMES, POSITIONS)
    model = FrequencyModel(linear, conditions.frequency, 5e-4, ROBOT.delay)
    response, jacobian = model.response_and_jacobian(linear.values)
    spectrum = input_spectrum(
        response, conditions, controller_response(LAW, LoopContext(ROBOT, 5e-4), conditions.frequency)
    )
    for place in range(3):
        total = np.zeros((4, 4))
        for k, frequency in enumerate(conditions.frequency):
            error = np.diag((2 * np.pi * frequency) ** 4 * conditions.encoder_variance)
            U = spectrum[place, k]
            covariance = np.kron(np.linalg.inv(U @ U.conj().T).conj(), error)
            psi = np.stack([jacobian[place, k, :, :, p].ravel(order="F") for p in range(4)], axis=1)
            total += 2 * (psi.conj().T @ np.linalg.solve(covariance, psi)).real
        assert found[place] == pytest.approx(conditions.share * total, rel=1e-6, abs=1e-3)


def test_lines_sum_to_the_position() -> None:
    conditions = experiment_conditions(specification(), ROBOT, 5e-4, 1, most_lines=10)
    by_line = frequency_information(ROBOT, NAMES, POSITIONS, conditions, LAW, 5e-4)
    assert by_line.shape == (3, 10, 4, 4)
    whole = position_information(ROBOT, NAMES, POSITIONS, conditions, LAW, 5e-4)
    assert conditions.share * by_line.sum(axis=1) == pytest.approx(whole)


def test_more_periods_and_larger_amplitudes_tell_more() -> None:
    small = experiment_conditions(specification(amplitude=0.01), ROBOT, 5e-4, 1, most_lines=10)
    large = experiment_conditions(specification(amplitude=0.02), ROBOT, 5e-4, 1, most_lines=10)
    first, second = (position_information(ROBOT, NAMES, POSITIONS, each, LAW, 5e-4) for each in (small, large))
    assert second == pytest.approx(4 * first)
