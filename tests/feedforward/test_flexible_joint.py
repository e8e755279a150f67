from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.feedforward.cases import edited_robot, joint_trajectory


def test_equation_5_5_for_one_axis() -> None:
    """u = (J_a + J_m) q'' + J_a J_m / k q'''' of the undamped two-mass axis."""
    robot = load_robot("two_mass")
    path = joint_trajectory(robot, [0.7], 0.5)
    specification = FeedforwardSpecification(method="flexible_joint", hold_compensation=False)
    reference = compute_reference(robot, path, specification, 1e-3, 0.5)
    q = path.evaluate(reference.time, 4)[:, :, 0]
    arm = float(robot.model.arm_inertia([0.0], []))
    motor = float(robot.model.motor_inertia([]))
    k = robot.joints[0].direction.spring.stiffness.value
    friction = robot.motors[0].specification.viscous_friction.value
    np.testing.assert_allclose(reference.motor_position[:, 0], q[0] + arm / k * q[2], atol=1e-13)
    np.testing.assert_allclose(reference.motor_velocity[:, 0], q[1] + arm / k * q[3], atol=1e-11)
    expected = (arm + motor) * q[2] + arm * motor / k * q[4] + friction * (q[1] + arm / k * q[3])
    np.testing.assert_allclose(reference.torque[:, 0], expected, atol=1e-9 * np.abs(expected).max())


def test_flatness_is_exact_for_an_undamped_elbow_under_gravity() -> None:
    """Motion and torque meet both equations of motion of the full model at every sample."""

    def undamp(data: dict[str, list[dict[str, dict[str, dict[str, object]]]]]) -> None:
        for body in data["bodies"]:
            for direction in body.get("directions", {}).values():
                direction["damper"] = 0

    robot = edited_robot("elbow", undamp)
    path = joint_trajectory(robot, [0.6, -0.8], 0.6)
    specification = FeedforwardSpecification(method="flexible_joint", hold_compensation=False)
    reference = compute_reference(robot, path, specification, 1e-3, 0.6)
    q, v, a = path.evaluate(reference.time, 2)
    model, p = robot.model, robot.model.parameter_values
    for k in range(0, 601, 100):
        state = np.concatenate([q[k], reference.motor_position[k]])
        rate = np.concatenate([v[k], reference.motor_velocity[k]])
        acceleration = np.array(model.acceleration(state, rate, reference.torque[k], np.zeros(6), p)).ravel()
        np.testing.assert_allclose(acceleration[:2], a[k], atol=1e-8 * np.abs(a).max())
        before, after = (compute_velocity(reference, k, side) for side in (-1, 1))
        if 0 < k < 600:
            np.testing.assert_allclose(acceleration[2:], (after - before) / 2e-3, atol=0.02 * np.abs(a).max())


def compute_velocity(reference: object, k: int, side: int) -> np.ndarray:
    velocity = reference.motor_velocity  # type: ignore[attr-defined]
    return velocity[min(max(k + side, 0), len(velocity) - 1)]


def test_elbow_moves_stay_on_their_path_in_closed_loop() -> None:
    experiment = Experiment.prepare(load_scenario("elbow_moves").with_values({"noise": False}))
    log = closed_loop(experiment)
    assert log.tool_pose is not None
    error = np.abs(log.tool_pose.position - experiment.reference.tool_pose[:, :3])
    assert error.max() < 2e-4  # undamped model of a damped gear


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["six_axis_moves"])
def test_six_axis_torque_holds_gravity_at_the_start(scenario: str) -> None:
    experiment = Experiment.prepare(load_scenario(scenario).with_values({"duration": 0.01}))
    robot = experiment.nominal
    rigid = robot.holding_torque(robot.equilibrium(robot.home))
    np.testing.assert_allclose(experiment.reference.torque[0], rigid, atol=0.02 * np.abs(rigid).max())
