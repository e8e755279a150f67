from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import joint_trajectory


def test_rigid_torque_of_the_emps_axis() -> None:
    emps = load_robot("emps")
    path = joint_trajectory(emps, [0.25], 1.0)
    specification = FeedforwardSpecification(method="rigid", hold_compensation=False)
    reference = compute_reference(emps, path, specification, 1e-3, 1.2)
    _, v, a = path.evaluate(reference.time, 2)[:, :, 0]
    mass = float(emps.model.mass_matrix([0.0], []))
    drag = -float(emps.model.force([0.0], [1.0], [0.0], np.zeros(6), []))
    np.testing.assert_allclose(reference.torque[:, 0], mass * a + drag * v, atol=1e-10)
    np.testing.assert_allclose(reference.motor_position[:, 0], path.evaluate(reference.time, 0)[0, :, 0], atol=1e-14)


def test_torque_of_e12_is_that_of_arm_and_motors_moving_together(e12: Robot, smooth: Trajectory) -> None:
    specification = FeedforwardSpecification(method="rigid", hold_compensation=False)
    reference = compute_reference(e12, smooth, specification, 1e-3, 0.8)
    q, v = reference.motor_position, reference.motor_velocity
    a = np.gradient(v, 1e-3, axis=0, edge_order=2)
    arm = np.array([*q[300], 0.0])
    inertia = np.array(e12.model.arm_inertia(arm, []))[:2, :2] + 100.0 * np.eye(2)
    velocity_force = np.array(e12.model.arm_force(arm, [*v[300], 0], q[300], v[300], [])).ravel()[:2]
    np.testing.assert_allclose(reference.torque[300], inertia @ a[300] - velocity_force, rtol=2e-3)


@pytest.mark.slow
def test_motor_position_is_that_of_the_rigid_arm(e12: Robot, smooth: Trajectory) -> None:
    reference = compute_reference(e12, smooth, FeedforwardSpecification(method="rigid"), 5e-3, 0.8)
    for position, output in zip(reference.motor_position, reference.output, strict=True):
        np.testing.assert_allclose(e12.forward_kinematics([*position, 0.0]), output, atol=1e-13)


@pytest.mark.slow
def test_without_feedforward_the_torque_is_zero(e12: Robot, smooth: Trajectory) -> None:
    rigid, none = (
        compute_reference(e12, smooth, FeedforwardSpecification(method=method), 5e-3, 0.8)
        for method in ("rigid", "none")
    )
    assert not none.torque.any()
    np.testing.assert_array_equal(none.motor_position, rigid.motor_position)
