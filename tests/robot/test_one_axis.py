"""The one-axis robots against equations 4.8 to 4.10, Table 3 and figures derived from it."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.linear.zeros import channel_zeros, poles


def _oscillating_hz(values: np.ndarray) -> np.ndarray:
    return np.sort(np.abs(values[values.imag > 1e-6])) / (2 * np.pi)


def test_two_mass_pole_and_zero() -> None:
    robot = load_robot("two_mass")
    k, d = (robot.parameters[f"body_1.rz.{key}"].value for key in ("stiffness", "damping"))
    J_a, J_m = robot.parameters["body_1.inertia.zz"].value, robot.parameters["motor_1.inertia"].value
    linear = linear_model(robot)
    zero = channel_zeros(linear, 0, 0)[-1]
    pole = poles(linear)[-1]
    assert abs(zero) == pytest.approx(np.sqrt(k / J_a), rel=1e-9)
    assert abs(pole) == pytest.approx(np.sqrt(k * (J_a + J_m) / (J_a * J_m)), rel=1e-9)
    assert -zero.real / abs(zero) == pytest.approx(d / 2 * np.sqrt(1 / (k * J_a)), rel=1e-9)
    assert -pole.real / abs(pole) == pytest.approx(d / 2 * np.sqrt((J_a + J_m) / (k * J_a * J_m)), rel=1e-9)


def test_two_mass_equations_of_motion() -> None:
    robot = load_robot("two_mass")
    value = {name: parameter.value for name, parameter in robot.parameters.items()}
    k, d = value["body_1.rz.stiffness"], value["body_1.rz.damping"]
    q, v, tau = np.array([0.1, 0.3]), np.array([-0.4, 0.7]), 5.0
    a = np.asarray(robot.model.acceleration(q, v, [tau], np.zeros(6), [])).ravel()
    spring = k * (q[0] - q[1]) + d * (v[0] - v[1])
    np.testing.assert_allclose(value["body_1.inertia.zz"] * a[0] + spring, 0, atol=1e-9)
    np.testing.assert_allclose(value["motor_1.inertia"] * a[1] - spring, tau, rtol=1e-9)


def test_four_mass_linear_poles_and_zeros() -> None:
    linear = linear_model(load_robot("four_mass_linear"))
    np.testing.assert_allclose(_oscillating_hz(poles(linear)), [12.40256, 19.12072, 54.66408], atol=5e-6)
    assert poles(linear)[1].real == pytest.approx(-0.19149, abs=5e-6)
    np.testing.assert_allclose(_oscillating_hz(channel_zeros(linear, 0, 0)), [5.25506, 15.37826, 52.32049], atol=5e-6)


def test_four_mass_matrices_of_table_3() -> None:
    """In absolute angles the model has the matrices of equations 4 to 7."""
    linear = linear_model(load_robot("four_mass_linear"))
    absolute = np.array([[1, 0, 0, 0], [-1, 1, 0, 0], [0, -1, 1, 0], [0, 0, 0, 1.0]])  # [q_a1 q_a2 q_a3 q_m] -> ours
    M, D, K = (absolute.T @ matrix @ absolute for matrix in (linear.mass, linear.damping, linear.stiffness))
    np.testing.assert_allclose(M, np.diag([2e-3, 0.02, 0.02, 5e-3]), atol=1e-15)
    expected_K = [[210, -110, 0, -100], [-110, 190, -80, 0], [0, -80, 80, 0], [-100, 0, 0, 100]]
    np.testing.assert_allclose(K, expected_K, atol=1e-11)
    expected_D = [[0.14, -0.06, 0, -0.08], [-0.06, 0.14, -0.08, 0], [0, -0.08, 0.08, 0], [-0.08, 0, 0, 0.08]]
    np.testing.assert_allclose(D, expected_D + np.diag([1e-3, 1e-3, 1e-3, 6e-3]), atol=1e-14)


def test_four_mass_tool_position_is_equation_8() -> None:
    robot = load_robot("four_mass")
    absolute = np.array([0.3, 0.5, -0.2])
    relative = np.diff(absolute, prepend=0)
    expected = (0.02 * absolute[0] + 0.6 * absolute[1] + 1.53 * absolute[2]) / 220
    assert robot.forward_kinematics(relative)[0] == pytest.approx(expected, rel=1e-12)
    assert robot.tool_pose(relative)[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("deflection", [0.01, 0.03, 0.1])
def test_four_mass_gear_is_odd_and_piecewise_linear(deflection: float) -> None:
    model = load_robot("four_mass").model

    def torque(angle: float) -> float:
        return float(model.transmission_force([0, 0, 0], np.zeros(3), [angle], [0], [])[0])

    knots, slopes = [0, 0.016, 0.032, 0.048, 0.064, np.inf], [16.7, 37.525, 58.35, 79.175, 100]
    expected = sum(k * (min(max(deflection, a), b) - a) for k, a, b in zip(slopes, knots, knots[1:]))
    assert torque(deflection) == pytest.approx(expected, rel=1e-12)
    assert torque(-deflection) == pytest.approx(-expected, rel=1e-12)


def test_tool_torque_acts_on_the_last_mass() -> None:
    a = load_robot("four_mass_linear").model.acceleration(np.zeros(4), np.zeros(4), [0], [0, 0, 0, 0, 0, 1.0], [])
    absolute = np.cumsum(np.asarray(a).ravel()[:3])
    np.testing.assert_allclose(absolute, [0, 0, 1 / 0.02], atol=1e-9)


def test_emps_is_a_mass_with_viscous_friction() -> None:
    a = load_robot("emps").model.acceleration([0.1], [0.5], [300.0], np.zeros(6), [])
    assert float(a) == pytest.approx((300 - 203.5034 * 0.5) / 95.1089, rel=1e-12)
