"""Viscous friction brakes in proportion to speed, each direction with its own coefficient."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.simulate.plant import Plant


def friction_beyond_nominal(speed: float, parameters: str) -> float:
    """Coast from a speed: friction beyond the nominal one, relative to it."""
    robot = load_robot("emps")
    nominal = robot.parameters["motor_1.viscous_friction"].value
    mass = robot.parameters["motor_1.inertia"].value + robot.parameters["body_1.mass"].value
    placed = place_effects(robot, [parse_effect(f"viscous_friction@motor_1:{parameters}", "test")])
    plant = Plant(placed.robot, 1e-3, np.array([0.0, speed]), laws=placed.laws)
    for _ in range(500):
        plant.advance([0.0])
    whole = -mass * np.log(plant.state[1] / speed) / 0.5
    return float(whole / nominal - 1)


@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_coefficient_comes_on_top_of_the_nominal_one(speed: float) -> None:
    nominal = load_robot("emps").parameters["motor_1.viscous_friction"].value
    assert friction_beyond_nominal(speed, f"coefficient={0.25 * nominal}") == pytest.approx(0.25, rel=1e-8)


@pytest.mark.parametrize(("speed", "sign"), [(0.5, 1), (-0.5, -1)])
def test_asymmetry_is_of_the_whole_friction(speed: float, sign: int) -> None:
    nominal = load_robot("emps").parameters["motor_1.viscous_friction"].value
    relative = friction_beyond_nominal(speed, f"coefficient={0.25 * nominal},asymmetry=0.4")
    assert 1 + relative == pytest.approx(1.25 * (1 + 0.2 * sign), rel=1e-8)


@pytest.mark.parametrize(("speed", "sign"), [(0.5, 1), (-0.5, -1)])
def test_asymmetry_without_coefficient_makes_the_nominal_friction_differ_in_the_directions(
    speed: float, sign: int
) -> None:
    assert friction_beyond_nominal(speed, "asymmetry=0.4") == pytest.approx(0.2 * sign, rel=1e-7)
    assert friction_beyond_nominal(speed, "asymmetry=-0.4") == pytest.approx(-0.2 * sign, rel=1e-7)


def test_nominal_friction_that_is_too_large_is_a_coefficient_below_zero() -> None:
    nominal = load_robot("emps").parameters["motor_1.viscous_friction"].value
    assert friction_beyond_nominal(0.5, f"coefficient={-0.4 * nominal}") == pytest.approx(-0.4, rel=1e-8)


def test_friction_that_drives_a_motor_is_refused() -> None:
    with pytest.raises(InputError, match="coefficient is -300.*203.503"):
        place_effects(load_robot("emps"), [parse_effect("viscous_friction@motor_1:coefficient=-300", "test")])
