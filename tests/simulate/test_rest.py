"""States of rest for many parameters equal those of robots built one by one."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.simulate.rest import RestFinder


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("elbow", {"body_2.mass": 80.0, "body_1.ry.stiffness": 1.5e5}),
        ("six_axis", {"body_7.mass": 250.0, "body_3.rx.stiffness": 1e6}),
        ("e12", {"body_3.mass": 250.0}),
        ("four_mass", {"body_2.rz.stiffness": 100.0}),
        ("emps", {"body_1.mass": 80.0}),
    ],
)
def test_rest_equals_that_of_the_robot_itself(name: str, values: dict[str, float]) -> None:
    robot = load_robot(name)
    near = robot.equilibrium()
    motors = robot.model.encoder(near[: robot.n_coordinates]).full().ravel()
    other = robot.with_values(values)
    expected = other.equilibrium(motor_position=motors)
    rest = RestFinder(robot, robot.symbolic(tuple(values)), near).find(np.array(list(values.values())))
    np.testing.assert_allclose(rest.state, expected, atol=1e-12)
    np.testing.assert_allclose(rest.torque, other.holding_torque(expected), atol=1e-6)


def test_values_without_a_rest_are_told() -> None:
    robot = load_robot("elbow")
    finder = RestFinder(robot, robot.symbolic(("body_1.ry.stiffness",)), robot.equilibrium())
    with pytest.raises(InputError, match=r"robot elbow finds no rest with body_1\.ry\.stiffness = nan"):
        finder.find(np.array([np.nan]))
