"""The complete flexible joint model (equation 3.12) against Lagrange and the thesis' structure."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.robot import Robot, robot_from_data
from flexros.robot.robot import LIBRARY


@pytest.fixture(scope="module", params=["elbow", "six_axis"])
def robot(request: pytest.FixtureRequest) -> Robot:
    data = read_yaml(LIBRARY / f"{request.param}.yaml")
    return robot_from_data({**data, "inertial_coupling": True}, "coupled")


def _coupling(robot: Robot, q: np.ndarray) -> np.ndarray:
    return np.asarray(robot.model.mass_matrix(q, []))[: robot.n_arm, robot.n_arm :]


def test_planar_coupling_is_rotor_inertia_over_gear_ratio() -> None:
    data = read_yaml(LIBRARY / "elbow.yaml")
    robot = robot_from_data({**data, "inertial_coupling": True}, "coupled")
    np.testing.assert_allclose(_coupling(robot, np.zeros(4)), [[0, 25 / 100], [0, 0]], atol=1e-15)


def test_coupling_is_strictly_upper_triangular_over_the_gears(robot: Robot) -> None:
    q = 0.4 * np.random.default_rng(0).normal(size=robot.n_coordinates)
    S = _coupling(robot, q)[list(robot.gear_rows)]
    np.testing.assert_allclose(np.tril(S), 0, atol=1e-12)
    assert np.abs(S).max() > 0


def test_coupled_motion_obeys_lagrange(robot: Robot) -> None:
    """d/dt dT/dv - dT/dq of the coupled kinetic energy equals what the model adds to the uncoupled one."""
    n, N = robot.n_coordinates, robot.n_arm
    rng = np.random.default_rng(1)
    q, v, u, w = 0.4 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=robot.n_motors), rng.normal(size=6)
    a = np.asarray(robot.model.acceleration(q, v, u, w, [])).ravel()
    qs, vs = ca.SX.sym("q", n), ca.SX.sym("v", n)
    S = robot.model.mass_matrix(qs, [])[:N, N:]
    energy = ca.bilin(S, vs[:N], vs[N:])
    momentum = ca.gradient(energy, vs)
    change = ca.jtimes(momentum, qs, vs) + ca.jtimes(momentum, vs, ca.DM(a)) - ca.gradient(energy, qs)
    coupled = np.asarray(ca.Function("c", [qs, vs], [change])(q, v)).ravel()
    data = robot.spec.model_copy(update={"inertial_coupling": False})
    plain = Robot(data, "plain").model
    force = np.asarray(plain.force(q, v, u, w, [])).ravel() - np.asarray(plain.mass_matrix(q, [])) @ a
    np.testing.assert_allclose(coupled, force, atol=1e-8 * np.abs(force).max() + 1e-9)
