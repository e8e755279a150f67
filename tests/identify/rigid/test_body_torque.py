"""Torque of the bodies of a rigid robot, against the regressor and its standard parameters."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.body_torque import LANES, BodyTorque, body_torque
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.standard_parameters import standard_parameters
from tests.ur5e import ur5e


@pytest.mark.parametrize("n", [1, LANES, 2 * LANES + 3])
def test_torque_is_that_of_the_standard_parameters_of_the_bodies(n: int) -> None:
    """Also with numbers of bodies in place of the nominal ones, and for samples that do not fill the last lanes."""
    robot, rng = ur5e(), np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, n, robot.n_motors))
    numbers = {"body_3.mass": 5.0, "body_5.center_of_mass.y": 0.1, "body_6.inertia.xx": 0.3, "motor_1.inertia": 9.0}
    standard = standard_parameters(robot, numbers=numbers)
    values = np.array([one.nominal if one.name.startswith("body") else 0.0 for one in standard])
    expected = RigidRegressor(robot).matrix(q, v, a) @ values
    np.testing.assert_allclose(BodyTorque(robot)(q, v, a, numbers), expected, rtol=1e-9, atol=1e-9)


def test_it_is_compiled_once_for_a_robot() -> None:
    assert body_torque(ur5e()) is body_torque(ur5e())
