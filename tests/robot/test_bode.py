"""Frequency response and its picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.bode import frequency_response, write_bode
from flexros.robot.linearise import linear_model


@pytest.mark.parametrize("name", ["e12", "four_mass_linear", "six_axis"])
def test_response_agrees_with_the_state_space_form(name: str) -> None:
    linear = linear_model(load_robot(name))
    frequency = np.array([1.7, 9.3, 41.0])
    A, B, C, _ = linear.matrices()
    for f, response in zip(frequency, frequency_response(linear, frequency)):
        expected = C @ np.linalg.solve(2j * np.pi * f * np.eye(len(A)) - A, B)
        np.testing.assert_allclose(response, expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())


def test_picture_opens_without_a_network(tmp_path: Path) -> None:
    file = tmp_path / "bode.html"
    write_bode(linear_model(load_robot("e12")), file, "e12")
    text = file.read_text()
    assert "torque of motor_2: phase" in text
    assert '<script src="http' not in text
    assert list(tmp_path.iterdir()) == [file]
