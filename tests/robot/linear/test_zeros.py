"""Zeros and zero dynamics against figures derived from the thesis and against known systems."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal

from flexros.robot import load_robot, robot_from_data
from flexros.robot.linear.linearise import linear_model
from flexros.robot.linear.zeros import channel_zeros, invariant_zeros, poles, transmission_zeros, zero_dynamics


def _hz(values: np.ndarray) -> np.ndarray:
    return np.sort(np.abs(values[values.imag > 1e-6])) / (2 * np.pi)


def test_e12_poles() -> None:
    np.testing.assert_allclose(_hz(poles(linear_model(load_robot("e12")))), [5.17324, 7.13344, 15.82318], atol=5e-6)


def test_e12_zeros_of_the_first_motor() -> None:
    zeros = channel_zeros(linear_model(load_robot("e12")), 0, 0)
    np.testing.assert_allclose(_hz(zeros), [2.44119, 7.00413, 15.73766], atol=5e-6)


def test_e12_transmission_zeros() -> None:
    zeros = transmission_zeros(linear_model(load_robot("e12")))
    np.testing.assert_allclose(zeros[:2], [-0.625 - 49.99609j, -0.625 + 49.99609j], atol=1e-5)
    np.testing.assert_allclose(zeros[2:], [-2000, -2000], rtol=1e-6)


def test_e12_zero_dynamics() -> None:
    verdict = zero_dynamics(load_robot("e12"))
    assert verdict.minimum_phase
    np.testing.assert_allclose(np.abs(verdict.eigenvalues), 50, rtol=1e-9)
    np.testing.assert_allclose(-verdict.eigenvalues.real / 50, 0.0125, rtol=1e-6)


def test_six_axis_tool_pose_is_non_minimum_phase() -> None:
    verdict = zero_dynamics(load_robot("six_axis"), output="tool")
    assert not verdict.minimum_phase
    assert verdict.unstable.size >= 1


@pytest.mark.slow
def test_six_axis_joints_are_minimum_phase() -> None:
    verdict = zero_dynamics(load_robot("six_axis"), output="joints")
    assert verdict.minimum_phase
    assert verdict.eigenvalues.size == 24


def test_flexible_joint_robot_has_no_zero_dynamics() -> None:
    verdict = zero_dynamics(load_robot("elbow"))
    assert verdict.eigenvalues.size == 0
    assert verdict.minimum_phase


def test_coupled_rotors_can_make_a_robot_non_minimum_phase() -> None:
    """Two axes at right angles; the second rotor is turned by the elastic direction before it."""
    motor = {"inertia": 10, "gear_ratio": 2}
    turning = {"spring": 1e5, "damper": 50, "motor": motor}
    first = {"mass": 20, "center_of_mass": [0.2, 0, 0], "inertia": {"xx": 1, "yy": 1, "zz": 1}, "length": [0.5, 0, 0]}
    second = {"mass": 10, "center_of_mass": [-0.25, 0, 0], "inertia": {"xx": 0.1, "yy": 0.1, "zz": 0.1}}
    bodies = [
        {**first, "directions": {"rz": turning, "ry": {"spring": 2e4, "damper": 10}}},
        {**second, "directions": {"ry": {**turning, "spring": 5e4}}},
    ]
    outputs = {"joints": {"coordinates": ["body_1.rz", "body_2.ry"]}}
    data = {"name": "two rotors", "bodies": bodies, "outputs": outputs, "controlled": "joints"}
    assert zero_dynamics(robot_from_data(data, "plain")).minimum_phase
    coupled = robot_from_data({**data, "inertial_coupling": True}, "coupled")
    verdict = zero_dynamics(coupled)
    assert verdict.solvable
    assert not verdict.minimum_phase
    np.testing.assert_allclose(verdict.unstable, [261.949], atol=1e-3)
    np.testing.assert_allclose(verdict.eigenvalues, transmission_zeros(linear_model(coupled)), rtol=1e-9)
    model = linear_model(coupled)
    s, held = verdict.unstable.real[0], [1, 3, 4]  # columns of the elastic direction and the motors; gears stand still
    arm = (model.stiffness + s * model.damping + s**2 * model.mass)[:3, held]
    singular = np.linalg.svd(arm, compute_uv=False)
    assert singular[-1] < 1e-9 * singular[0]


def test_outstretched_arm_cannot_be_inverted() -> None:
    verdict = zero_dynamics(load_robot("e12"), q_a=[0.3, 0.0, 0.0])
    assert not verdict.solvable
    assert not verdict.minimum_phase


def test_invariant_zeros_of_a_known_transfer_function() -> None:
    A, B, C, D = scipy.signal.tf2ss([1, -3], np.poly([-1, -2, -4, -5]))
    np.testing.assert_allclose(invariant_zeros(A, B, C, D), [3], rtol=1e-8)


def test_right_half_plane_zero_of_e12_with_a_tool_far_ahead() -> None:
    """A tool point far beyond the centre of percussion makes the last link non-minimum phase."""
    robot = load_robot("e12").with_values({"body_3.length.x": 1.0, "body_3.inertia.yy": 5.0})
    verdict = zero_dynamics(robot)
    A, B, C, D = linear_model(robot).matrices()
    all_zeros = invariant_zeros(A, B, C[2:], D[2:])
    np.testing.assert_allclose(
        np.sort(verdict.unstable.real), np.sort(all_zeros[all_zeros.real > 1e-6].real), rtol=1e-6
    )
    assert not verdict.minimum_phase


@pytest.mark.slow
@pytest.mark.parametrize("name", ["e12", "elbow", "six_axis"])
def test_zero_dynamics_are_among_the_transmission_zeros(name: str) -> None:
    robot = load_robot(name)
    zeros = transmission_zeros(linear_model(robot))
    for value in zero_dynamics(robot).eigenvalues:
        assert np.min(np.abs(zeros - value)) < 1e-6 * (1 + abs(value))


@pytest.mark.slow
def test_state_space_is_a_python_control_object() -> None:
    import control

    linear = linear_model(load_robot("two_mass"))
    system = linear.state_space()
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["motor_1"]
    assert system.output_labels == ["motor_1", "body_1_rz"]
    np.testing.assert_allclose(np.sort(np.abs(system.poles())), np.sort(np.abs(poles(linear))), atol=1e-3)
