"""Prior covariance of the parameters of the regression."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.base_parameters import base_parameters
from flexros.identify.rigid.prior import PRIOR, prior_factor
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.standard_parameters import standard_parameters
from flexros.robot import Robot, load_robot


def prior_covariance(robot: Robot) -> tuple[np.ndarray, list[str]]:
    base = base_parameters(RigidRegressor(robot), robot.n_motors)
    factor = prior_factor(robot, base)
    return factor @ factor.T, [parameter.name for parameter in base.standard]


@pytest.mark.slow
def test_prior_is_that_of_robots_with_scattered_parameters() -> None:
    robot, rng = load_robot("elbow"), np.random.default_rng(1)
    scattered = ("body_2.mass", "body_2.inertia.yy", "motor_2.inertia")
    drawn = []
    for _ in range(400):
        values = {name: robot.parameters[name].value * (1 + PRIOR * rng.normal()) for name in scattered}
        centre = rng.normal(size=3) * PRIOR * 0.35
        values |= {
            f"body_2.center_of_mass.{axis}": centre[k] + (0.35 if axis == "x" else 0) for k, axis in enumerate("xyz")
        }
        values["body_2.mass"] = max(values["body_2.mass"], 1.0)
        values |= {f"body_2.inertia.{entry}": 30.0 for entry in ("xx", "zz")}  # leave room for yy
        drawn.append([parameter.nominal for parameter in standard_parameters(robot.with_values(values))])
    expected, names = prior_covariance(robot)
    for name in ("body_2.mass", "body_2.first_moment.x", "motor_2.inertia", "body_2.first_moment.z"):
        place = names.index(name)
        assert np.sqrt(expected[place, place]) == pytest.approx(np.std(np.array(drawn)[:, place]), rel=0.15), name
    mass, moment = names.index("body_2.mass"), names.index("body_2.first_moment.x")
    assert expected[mass, moment] == pytest.approx(0.35 * expected[mass, mass])


def test_parameters_of_zero_move_as_others_of_their_kind() -> None:
    robot = load_robot("elbow")
    without = robot.with_values({"motor_2.viscous_friction": 0.0})
    covariance, names = prior_covariance(without)
    place = names.index("motor_2.viscous_friction")
    largest = robot.parameters["motor_1.viscous_friction"].value
    assert covariance[place, place] == pytest.approx((0.02 * largest) ** 2)


def test_friction_that_no_file_gives_has_room() -> None:
    covariance, names = prior_covariance(load_robot("elbow"))
    place = names.index("motor_1.coulomb_friction")
    assert covariance[place, place] == 1.0
