"""Mapping between motors, gears and arm coordinates of a chain."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.robot import Robot, load_robot, robot_from_data, robot_names
from flexros.robot.robot import LIBRARY


@pytest.fixture(scope="module")
def mixed() -> Robot:
    """The robot of Paper B with its first gear rigid."""
    data = read_yaml(LIBRARY / "e12.yaml")
    data["bodies"][0]["directions"]["ry"]["spring"] = "rigid"
    return robot_from_data(data, "mixed")


def test_rigid_and_flexible_gears_are_distinguished(mixed: Robot) -> None:
    assert mixed.gear_rows == (0, 1)
    assert mixed.stiff_motors == (0,)
    assert mixed.flexible_motors == (1,)
    assert mixed.spring_rows == (1, 2)


def test_motor_behind_a_rigid_gear_has_the_row_of_its_arm_coordinate(mixed: Robot) -> None:
    assert mixed.motor_rows == (0, 3)


@pytest.mark.parametrize("name", robot_names())
def test_motor_rows_are_what_the_encoders_measure(name: str) -> None:
    robot = load_robot(name)
    q = np.arange(1.0, robot.n_coordinates + 1.0)
    np.testing.assert_array_equal(robot.model.encoder(q).full().ravel(), q[list(robot.motor_rows)])


def test_arm_from_gears_leaves_elastic_directions_at_zero() -> None:
    chain = load_robot("e12").chain
    np.testing.assert_array_equal(chain.arm_from_gears(np.array([1.0, 2.0])), [1, 2, 0])
    np.testing.assert_array_equal(chain.arm_from_gears(np.array([[1.0, 2.0], [3.0, 4.0]])), [[1, 2, 0], [3, 4, 0]])


def test_arm_from_gears_of_symbols_equals_that_of_numbers() -> None:
    chain = load_robot("six_axis").chain
    gears, symbols = np.arange(1.0, 7.0), ca.SX.sym("theta", 6)
    arm = ca.Function("arm", [symbols], [ca.densify(chain.arm_from_gears(symbols))])(gears)
    np.testing.assert_array_equal(arm.full().ravel(), chain.arm_from_gears(gears))
