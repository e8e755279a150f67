"""The robot of Paper B against the thesis and figures derived from it (Lagrange)."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import Robot, load_robot


@pytest.fixture(scope="module")
def e12() -> Robot:
    return load_robot("e12")


def test_start_pose_of_the_tool(e12: Robot) -> None:
    np.testing.assert_allclose(e12.forward_kinematics([0, 0.3, 0]), [2.146403786951, -0.354624247994], atol=1e-12)


def test_inertia_matrix_at_the_start(e12: Robot) -> None:
    M = np.asarray(e12.model.arm_inertia([0, 0.3, 0], []))
    expected = [
        [1167.8817041278, 579.9408520639, 91.1067297825],
        [579.9408520639, 322, 72],
        [91.1067297825, 72, 52],
    ]
    np.testing.assert_allclose(M, expected, rtol=1e-12)


def test_inertia_matrix_in_another_pose(e12: Robot) -> None:
    M = np.asarray(e12.model.arm_inertia([0.1, 0.5, -0.05], []))
    expected = [
        [1126.7591754551, 559.3545929354, 89.9839472550],
        [559.3545929354, 321.9500104158, 71.9750052079],
        [89.9839472550, 71.9750052079, 52],
    ]
    np.testing.assert_allclose(M, expected, rtol=1e-12)


def test_velocity_term(e12: Robot) -> None:
    torque = e12.model.arm_inverse_dynamics([0.1, 0.5, -0.05], [0.3, -0.4, 0.2], np.zeros(3), [])
    np.testing.assert_allclose(-np.asarray(torque).ravel(), [-10.2844556267, -11.5700125800, -0.7729421275], atol=5e-11)


def test_spring_of_the_first_gear_pulls_towards_the_motor(e12: Robot) -> None:
    force = np.asarray(e12.model.transmission_force([0.01, 0, 0], np.zeros(3), [0, 0], [0, 0], [])).ravel()
    np.testing.assert_allclose(force, [-1000, 0, 0], atol=1e-9)


def test_no_gravity_and_no_motor_friction(e12: Robot) -> None:
    assert np.all(e12.holding_torque(e12.equilibrium([0.4, -0.2, 0])) == 0)
    assert all(e12.parameters[f"motor_{i}.viscous_friction"].value == 0 for i in (1, 2))


def test_every_value_is_exact_and_has_a_source(e12: Robot) -> None:
    assert all(parameter.tolerance == 0 and parameter.source for parameter in e12.parameters.values())
