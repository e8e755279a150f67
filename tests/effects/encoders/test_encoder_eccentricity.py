"""A reading that errs with the angle of the rotor."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.robot import load_robot
from flexros.simulate.plant import Plant


@pytest.mark.slow
@pytest.mark.parametrize(("robot_name", "turns"), [("six_axis", 180.0), ("two_mass", 1.0), ("four_mass", 1.0)])
def test_error_is_a_harmonic_of_the_rotor_angle(robot_name: str, turns: float) -> None:
    robot = load_robot(robot_name)
    text = "encoder_eccentricity@motor_1:amplitude=2e-4,order=3,phase=0.7"
    placed = place_effects(robot, [parse_effect(text, "test")])
    place = robot.motor_rows[0]
    for position in (0.0, 0.31, -0.02):
        state = np.zeros(2 * robot.n_coordinates)
        state[place] = position
        reading = Plant(placed.robot, robot.sample_time, state, laws=placed.laws).measure()
        assert reading[0] - position == pytest.approx(2e-4 * np.sin(3 * turns * position + 0.7), abs=1e-15)
        assert not reading[1:].any()


def test_true_motion_is_untouched() -> None:
    robot = load_robot("two_mass")
    text = "encoder_eccentricity@motor_1:amplitude=2e-4,order=3"
    placed = place_effects(robot, [parse_effect(text, "test")])
    paths = []
    for laws in (placed.laws, ()):
        plant = Plant(robot, robot.sample_time, np.array([0.0, 0.0, 1.0, 1.0]), laws=laws)
        for _ in range(50):
            plant.advance([20.0])
        paths.append(plant.state)
    assert np.array_equal(*paths)
