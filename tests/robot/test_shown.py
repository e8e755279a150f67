"""Tables of a robot and of its linear model."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.shown import modes


def test_modes_of_two_masses_are_those_of_the_spring() -> None:
    """w^2 = k (1/Ja + 1/Jm) with the motor on the arm side of the gear, damping d w / (2 k)."""
    robot = load_robot("two_mass")
    linear = linear_model(robot)
    inverse = np.linalg.inv(linear.mass)
    stiffness = robot.parameters["body_1.rz.stiffness"].value
    damping = robot.parameters["body_1.rz.damping"].value
    w = np.sqrt(np.max(np.linalg.eigvals(inverse @ linear.stiffness).real))
    (found,) = modes(linear)
    assert found[0] == pytest.approx(w / (2 * np.pi), rel=1e-4)
    assert found[1] == pytest.approx(damping * w / (2 * stiffness), rel=1e-2)


def test_tables_and_pictures() -> None:
    robot = load_robot("e12")
    linear = linear_model(robot, [0.0, 0.3, 0.0])
    frame = linear.to_pandas()
    assert list(frame.columns) == ["frequency_hz", "damping_ratio"]
    assert frame.index.tolist() == [1, 2, 3]
    assert robot.to_pandas().loc["body_1.mass", "unit"] == "kg"
    assert len(linear.plot().data) == 2 * 2 * len(linear.measurement_names)
    assert linear.to_control().ninputs == 2


def test_notebook_shows_motors_and_modes() -> None:
    html = load_robot("e12")._repr_html_()
    assert "motor_2" in html
    assert "damping ratio" in html
