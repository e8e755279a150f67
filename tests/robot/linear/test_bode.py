"""Frequency response and its picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.robot import load_robot, robot_from_data
from flexros.robot.linear.bode import frequency_response, write_bode
from flexros.robot.linear.linearise import linear_model
from flexros.robot.robot import LIBRARY

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", ["e12", "four_mass_linear", "six_axis"])
def test_response_agrees_with_the_state_space_form(name: str) -> None:
    linear = linear_model(load_robot(name))
    frequency = np.array([1.7, 9.3, 41.0])
    A, B, C, _ = linear.matrices()
    for f, response in zip(frequency, frequency_response(linear, frequency)):
        expected = C @ np.linalg.solve(2j * np.pi * f * np.eye(len(A)) - A, B)
        np.testing.assert_allclose(response, expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())


def test_curves_of_a_linear_motor_are_labelled_in_metres_and_newtons(tmp_path: Path) -> None:
    data = read_yaml(LIBRARY / "emps.yaml")
    data["outputs"]["joints"] = {"coordinates": ["body_1.tx"]}
    file = tmp_path / "bode.html"
    write_bode(linear_model(robot_from_data(data, "emps"), output="joints"), file, "emps")
    text = file.read_text().replace("\\u002f", "/").replace("\\u00b2", "²")
    assert "motor_1 [m/s²/N]" in text
    assert "body_1.tx [m/s²/N]" in text
    assert "force of motor_1: phase" in text
    assert "[rad/s" not in text


def test_pose_components_are_labelled_by_kind() -> None:
    linear = linear_model(load_robot("six_axis"), output="tool")
    assert linear.measurement_units == ("rad",) * 6 + ("m", "m", "m", "rad", "rad", "rad")
    assert linear.input_units == ("Nm",) * 6


def test_picture_opens_without_a_network(tmp_path: Path) -> None:
    file = tmp_path / "bode.html"
    write_bode(linear_model(load_robot("e12")), file, "e12")
    text = file.read_text()
    assert "torque of motor_2: phase" in text
    assert '<script src="http' not in text
    assert 'name="viewport"' in text, "a page of the kit, which fits a phone"
    assert list(tmp_path.iterdir()) == [file]
