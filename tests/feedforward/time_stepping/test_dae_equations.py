from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.time_stepping.dae_equations import LARGE_MODEL, build_equations
from flexros.robot import Robot, load_robot
from tests.feedforward.cases import subdivided_e12

pytestmark = pytest.mark.slow

GAMMA = 2000.0
RNG = np.random.default_rng(5)


@pytest.fixture(scope="module", params=["e12", "emps", "four_mass_linear", "elbow"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


def test_residual_is_the_equation_of_motion(robot: Robot) -> None:
    model, equations = robot.model, build_equations(robot.model)
    n, nq = robot.n_arm, robot.n_coordinates
    z, v, u = RNG.normal(0, 0.2, nq), RNG.normal(0, 0.5, nq), RNG.normal(0, 10, robot.n_motors)
    p = model.parameter_values
    a = np.array(model.acceleration(z, v, u, np.zeros(6), p)).ravel()
    stiff = list(robot.stiff_motors)
    unknowns = np.concatenate([z, u[stiff]])
    Z = np.array(model.output()(z[:n], p)).ravel()
    zero = np.zeros(len(unknowns))
    residual = np.array(equations.residual(zero, unknowns, v, a, GAMMA, 1.0, Z)).ravel()
    scale = np.max(np.abs(np.array(model.mass_matrix(z, p)))) * np.max(np.abs(a))
    assert np.max(np.abs(residual)) < 1e-12 * scale
    rate, torque, load, momentum, position, speed = (
        np.array(part).ravel() for part in equations.motion(zero, unknowns, v, a, GAMMA)
    )
    np.testing.assert_allclose(rate, v)
    np.testing.assert_allclose(torque, u, atol=1e-9 * scale)
    np.testing.assert_allclose(position, np.array(model.encoder(z)).ravel())
    assert len(speed) == len(load) == len(momentum) == robot.n_motors


def test_exact_newton_matrix_against_differences(robot: Robot) -> None:
    equations = build_equations(robot.model)
    assert equations.exact
    nz, nq = equations.n_unknowns, robot.n_coordinates
    arguments = (RNG.normal(0, 0.2, nz), RNG.normal(0, 0.5, nq), RNG.normal(0, 5.0, nq), GAMMA, 1.0 / GAMMA**2)
    matrix = np.array(equations.newton_matrix(np.zeros(nz), *arguments))
    Z, step = np.zeros(robot.n_motors), 1e-6
    for column in range(nz):
        x = np.zeros(nz)
        x[column] = step
        ahead, behind = (np.array(equations.residual(side, *arguments, Z)).ravel() for side in (x, -x))
        slope = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(matrix[:, column], slope, atol=1e-6 * np.abs(matrix).max())


def test_mass_based_matrix_is_near_the_exact_one_with_exact_output_rows(robot: Robot) -> None:
    exact, approximate = (build_equations(robot.model, exact=flag) for flag in (True, False))
    nz, nq, n = exact.n_unknowns, robot.n_coordinates, robot.n_arm
    arguments = (RNG.normal(0, 0.2, nz), RNG.normal(0, 0.1, nq), RNG.normal(0, 1.0, nq), GAMMA, 1.0 / GAMMA**2)
    one, other = (np.array(part.newton_matrix(np.zeros(nz), *arguments)) for part in (exact, approximate))
    np.testing.assert_array_equal(one[n:], other[n:])
    np.testing.assert_allclose(one[:n], other[:n], atol=1e-3 * np.abs(one[:n]).max())


def test_large_models_use_the_mass_based_matrix() -> None:
    small, large = (subdivided_e12(pieces).model for pieces in (LARGE_MODEL // 3, LARGE_MODEL // 3 + 1))
    assert small.n_arm == LARGE_MODEL < large.n_arm
    assert build_equations(small).exact
    assert not build_equations(large).exact


def test_large_models_have_the_matrix_that_is_asked_for() -> None:
    large = subdivided_e12(LARGE_MODEL // 3 + 1)
    chosen, approximate = build_equations(large.model), build_equations(large.model, exact=False)
    nz, nq = chosen.n_unknowns, large.n_coordinates
    arguments = (np.zeros(nz), RNG.normal(0, 0.2, nz), RNG.normal(0, 0.1, nq), np.zeros(nq), GAMMA, 1.0 / GAMMA**2)
    one, other = (np.array(part.newton_matrix(*arguments)) for part in (chosen, approximate))
    np.testing.assert_array_equal(one, other)
