"""Resonances and antiresonances of measured responses and of robots."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.axis.resonances import resonances_of_response, resonances_of_robot
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot import Robot, load_robot
from flexros.robot.linear.positions import linearise_positions
from tests.identify.axis.recorded_axis import three_mass


def response_of(robot: Robot, highest: float = 60.0) -> FrequencyResponse:
    """The exact response of a robot at home on lines 0.1 Hz apart."""
    frequency = np.arange(0.1, highest, 0.1)
    positions = linearise_positions(robot, (), robot.equilibrium(robot.home)[None, list(robot.motor_rows)])
    response = FrequencyModel(positions, frequency, robot.sample_time, robot.delay).response(positions.values)[0]
    motors = robot.n_motors
    return FrequencyResponse(
        frequency, response, None, None, np.tile(np.eye(motors, dtype=complex), (len(frequency), 1, 1)), 0.0,
        robot.joint_names, robot.joint_names, ("Nm",) * motors, ("rad",) * motors, np.zeros(motors), np.zeros(motors),
        robot.sample_time, 1, 1,
    )  # fmt: skip


def test_frequencies_of_two_masses_are_those_of_their_formulas() -> None:
    frequencies = resonances_of_robot(load_robot("two_mass"), "motor_1", 1)
    assert frequencies is not None
    np.testing.assert_allclose(frequencies.antiresonances, np.sqrt(6e4 / 6) / (2 * np.pi))
    np.testing.assert_allclose(frequencies.resonances, np.sqrt(6e4 * (1 / 6 + 1 / 4)) / (2 * np.pi))
    assert frequencies.source == "linear model of two_mass"


def test_three_masses_have_two_pairs_and_no_third() -> None:
    frequencies = resonances_of_robot(three_mass(), "motor_1", 2)
    assert frequencies is not None
    order = [f for pair in zip(frequencies.antiresonances, frequencies.resonances, strict=True) for f in pair]
    assert order == sorted(order)
    assert resonances_of_robot(three_mass(), "motor_1", 3) is None


def test_rigid_axis_has_none() -> None:
    assert resonances_of_robot(load_robot("emps"), "motor_1", 1) is None


@pytest.mark.parametrize("name", ["two_mass", "e12"])
def test_response_shows_what_the_robot_has(name: str) -> None:
    robot = load_robot(name)
    for joint in robot.joint_names:
        measured, known = resonances_of_response(response_of(robot), joint, 1), resonances_of_robot(robot, joint, 1)
        assert measured is not None
        assert known is not None
        np.testing.assert_allclose(measured.antiresonances, known.antiresonances, rtol=0.02)
        np.testing.assert_allclose(measured.resonances, known.resonances, rtol=0.02)


def test_response_below_the_peak_shows_no_pair() -> None:
    assert resonances_of_response(response_of(load_robot("two_mass"), highest=20.0), "motor_1", 1) is None
