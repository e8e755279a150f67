"""Viscous friction brakes in proportion to speed, each direction with its own coefficient."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.robot import load_robot
from flexros.simulate.plant import Plant


@pytest.mark.parametrize(("speed", "coefficient"), [(0.5, 50 * 1.2), (-0.5, 50 * 0.8)])
def test_speed_decays_with_the_coefficient_of_its_direction(speed: float, coefficient: float) -> None:
    robot = load_robot("emps")
    nominal = robot.parameters["motor_1.viscous_friction"].value
    mass = robot.parameters["motor_1.inertia"].value + robot.parameters["body_1.mass"].value
    placed = place_effects(robot, [parse_effect("viscous_friction@motor_1:coefficient=50,asymmetry=0.4", "test")])
    plant = Plant(placed.robot, 1e-3, np.array([0.0, speed]), laws=placed.laws)
    for _ in range(500):
        plant.advance([0.0])
    assert plant.state[1] == pytest.approx(speed * np.exp(-(nominal + coefficient) / mass * 0.5), rel=1e-9)
