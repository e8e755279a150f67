"""The bounded inverse against exact numbers, against time stepping, and in closed loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward.reference import Reference, compute_reference, pre_actuation, reference_chunks
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.feedforward.stable_inversion import bounded_inverse
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros.trajectory import Trajectory
from tests.feedforward.cases import CIRCLE, SMOOTH, edited_robot, joint_trajectory, problem_of, tool_trajectory

STABLE = {"method": "stable_inversion"}


@pytest.fixture(scope="module")
def long_tool() -> Robot:
    return load_robot("e12_long_tool")


@pytest.fixture(scope="module")
def delayed(long_tool: Robot) -> Trajectory:
    return tool_trajectory(long_tool, CIRCLE, SMOOTH).delayed(0.1)


def radial_error(name: str, **values: Any) -> float:
    """Return the largest radial deviation from the circle in closed loop [mm]."""
    experiment = Experiment.prepare(load_scenario(name).with_values(values))
    pose = closed_loop(experiment).tool_pose
    assert pose is not None
    centre = experiment.reference.output[0] - [0.025, 0.0]
    return float(1e3 * np.max(np.abs(np.hypot(*(pose.position[:, [0, 2]] - centre).T) - 0.025)))


def test_exact_inverse_dynamics_of_the_smooth_circle(e12: Robot, smooth: Trajectory) -> None:
    motion = bounded_inverse(problem_of(e12, smooth, 5e-4, 0.9, **STABLE)).motion
    np.testing.assert_allclose(motion.arm_position[800], [-0.11755577466, 0.52013162855, 0.00959511598], atol=2e-8)
    np.testing.assert_allclose(motion.motor_position[800], [-0.10564743424, 0.51020347290], atol=1e-7)
    np.testing.assert_allclose(motion.torque[800], [2535.627, -3724.009], atol=0.03)


def test_error_is_of_second_order(e12: Robot, smooth: Trajectory) -> None:
    errors = [
        bounded_inverse(problem_of(e12, smooth, h, 0.9, **STABLE)).motion.arm_position[round(0.4 / h), 2]
        - 0.00959511598
        for h in (2e-3, 1e-3)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_ten_thousand_unknowns_in_a_few_iterations(long_tool: Robot, delayed: Trajectory) -> None:
    newton = bounded_inverse(problem_of(long_tool, delayed, 5e-4, 1.0)).newton
    assert newton.unknowns.size > 10_000
    assert newton.iterations <= 6


@pytest.mark.slow
def test_circle_of_a_non_minimum_phase_robot_in_closed_loop() -> None:
    assert radial_error("circle_stable_inversion") < 0.001
    assert radial_error("circle_stable_inversion", feedforward={"method": "flexible_joint"}) == pytest.approx(
        1.288, abs=0.002
    )
    assert radial_error("circle_stable_inversion", feedforward={"method": "rigid"}) == pytest.approx(24.35, abs=0.02)


@pytest.mark.slow
def test_tool_of_the_six_axis_robot_in_closed_loop() -> None:
    scenario = load_scenario("six_axis_moves").with_values(
        {
            "noise": False,
            "trajectory": {
                "path": {"type": "joint_moves", "points_from_start": [[0.05] * 6]},
                "time_law": {"type": "ninth_degree", "duration": 0.6},
            },
            "feedforward": {"method": "dae", "output": "tool"},
        }
    )
    experiment = Experiment.prepare(scenario)
    assert experiment.pre_actuation == pytest.approx(0.0425, abs=1e-3)
    pose = closed_loop(experiment).tool_pose
    assert pose is not None
    error = np.linalg.norm(pose.position - experiment.reference.tool_pose[:, :3], axis=1)
    assert 1e3 * error.max() < 0.001


def test_motors_move_before_the_tool_and_rest_before_that(long_tool: Robot, delayed: Trajectory) -> None:
    motion = bounded_inverse(problem_of(long_tool, delayed, 5e-4, 1.0)).motion
    moved = np.abs(motion.motor_position[:, 0] - motion.motor_position[0, 0])
    assert moved[200] > 3e-6  # the tool begins to move
    assert moved[40] < 1e-5 * moved[200]
    tool = np.array([long_tool.forward_kinematics(q, "tool") for q in motion.arm_position[[0, 100, 200]]])
    np.testing.assert_allclose(tool, np.tile(tool[0], (3, 1)), atol=1e-12)


def test_dae_uses_stable_inversion_where_the_zero_dynamics_are_unstable(long_tool: Robot, delayed: Trajectory) -> None:
    by_itself, by_name = (
        compute_reference(long_tool, delayed, FeedforwardSpecification(method=method), 1e-3, 1.0)
        for method in ("dae", "stable_inversion")
    )
    np.testing.assert_array_equal(by_itself.torque, by_name.torque)


def test_dae_keeps_time_stepping_where_they_are_stable(e12: Robot, smooth: Trajectory) -> None:
    assert pre_actuation(e12, smooth, FeedforwardSpecification(), 5e-4) == 0.0


def test_refusal_stays_an_option(long_tool: Robot, delayed: Trajectory) -> None:
    with pytest.raises(InputError, match="use method stable_inversion"):
        compute_reference(long_tool, delayed, FeedforwardSpecification(non_minimum_phase="refuse"), 1e-3, 1.0)


def test_joints_as_output_need_no_motion_before(long_tool: Robot, delayed: Trajectory) -> None:
    assert pre_actuation(long_tool, delayed, FeedforwardSpecification(output="joints"), 5e-4) == 0.0


def test_trajectory_without_rest_is_refused(long_tool: Robot) -> None:
    path = tool_trajectory(long_tool, CIRCLE, SMOOTH)
    with pytest.raises(InputError, match=r"0\.07385 s before the tool, but the trajectory rests for 0 s"):
        compute_reference(long_tool, path, FeedforwardSpecification(), 5e-4, 0.9)


def test_scenario_rests_as_long_as_needed() -> None:
    experiment = Experiment.prepare(load_scenario("circle_stable_inversion"))
    assert experiment.pre_actuation == pytest.approx(0.074)
    assert experiment.trajectory.rest_before == pytest.approx(0.074)
    assert experiment.trajectory.duration == pytest.approx(0.974)
    assert "the motors move 0.074 s before the tool" in experiment.warnings[0]
    longer = Experiment.prepare(load_scenario("circle_stable_inversion").with_values({"trajectory.hold_before": 0.2}))
    assert longer.trajectory.rest_before == pytest.approx(0.2)


def test_chunks_joined_equal_the_whole(long_tool: Robot, delayed: Trajectory) -> None:
    settings = FeedforwardSpecification()
    whole = compute_reference(long_tool, delayed, settings, 1e-3, 1.0)
    joined = Reference.concatenate(list(reference_chunks(long_tool, delayed, settings, 1e-3, 1.0, chunk=77)))
    np.testing.assert_array_equal(joined.torque, whole.torque)
    np.testing.assert_array_equal(joined.motor_position, whole.motor_position)


def test_start_alone_is_at_rest(long_tool: Robot, delayed: Trajectory) -> None:
    start = compute_reference(long_tool, delayed, FeedforwardSpecification(), 1e-3, 0.0)
    whole = compute_reference(long_tool, delayed, FeedforwardSpecification(), 1e-3, 1.0)
    np.testing.assert_allclose(start.motor_position[0], whole.motor_position[0], atol=1e-8)


def test_nonlinear_gear_agrees_with_time_stepping() -> None:
    robot = load_robot("four_mass")
    path = joint_trajectory(robot, [0.5], 0.6)
    stable, stepped = (
        compute_reference(robot, path, FeedforwardSpecification(method=method, output="tool"), 5e-4, 0.8)
        for method in ("stable_inversion", "dae")
    )
    np.testing.assert_allclose(stable.motor_position, stepped.motor_position, atol=2e-5)
    difference = np.abs(stable.torque - stepped.torque)  # larger at the corners of the spring, where the torque jumps
    assert np.quantile(difference, 0.98) < 3e-3 * np.abs(stepped.torque).max()


@pytest.mark.parametrize(
    "change", [{"inertial_coupling": True}, {"gravity": [0, 0, -9.81]}], ids=["coupled", "gravity"]
)
def test_motion_meets_all_equations_of_motion(change: dict[str, Any]) -> None:
    robot = edited_robot("e12_long_tool", lambda data: data.update(change))
    path = tool_trajectory(robot, CIRCLE, SMOOTH).delayed(0.1)
    h = 5e-4
    motion = bounded_inverse(problem_of(robot, path, h, 1.0)).motion
    q = np.hstack([motion.arm_position, motion.motor_position])
    speed, acceleration = (q[2:] - q[:-2]) / (2 * h), (q[2:] - 2 * q[1:-1] + q[:-2]) / h**2
    model, p = robot.model, robot.model.parameter_values
    for k in (200, 700, 1000):
        force = model.force(q[k + 1], speed[k], motion.torque[k + 1], np.zeros(6), p)
        residual = np.array(model.mass_matrix(q[k + 1], p) @ acceleration[k] - force).ravel()
        assert np.abs(residual).max() < 2e-5 * np.abs(motion.torque).max()
