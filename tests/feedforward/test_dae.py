from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError, RunError
from flexros.feedforward.base import feedforward_method
from flexros.feedforward.dae import dae_stepper
from flexros.feedforward.motion import Motion
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import (
    CIRCLE,
    edited_robot,
    joint_trajectory,
    problem_of,
    smooth_circle,
    subdivided_e12,
    tool_trajectory,
)
from tests.oracles.index_one import output_drift, solve_index_one


def motion_of(problem: FeedforwardProblem) -> Motion:
    (motion,) = feedforward_method("dae").motions(problem, problem.n_samples)
    return motion


def test_backward_euler_figures_of_the_smooth_case(e12: Robot, smooth: Trajectory) -> None:
    motion = motion_of(problem_of(e12, smooth, 5e-4, 0.4, order=1))
    assert motion.arm_position[800, 2] == pytest.approx(0.00952840882, abs=2e-11)
    # round-off of the output, amplified by four differences, leaves 5 to 6 digits of the torque
    np.testing.assert_allclose(motion.torque[800], [2509.9918, -3742.9591], rtol=5e-6)


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_order_of_convergence(order: int, e12: Robot, smooth: Trajectory) -> None:
    exact = np.array([-0.11755577466, 0.52013162855, 0.00959511598])
    errors = []
    for sample_time in (4e-3, 2e-3, 1e-3):
        motion = motion_of(problem_of(e12, smooth, sample_time, 0.4, order=order))
        errors.append(np.abs(motion.arm_position[-1] - exact)[2])
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), order, atol=0.25)


@pytest.mark.parametrize("order", [1, 2])
def test_torque_converges_to_the_exact_one(order: int, e12: Robot, smooth: Trajectory) -> None:
    exact = np.array([2535.627, -3724.009])
    errors = [
        np.linalg.norm(motion_of(problem_of(e12, smooth, step, 0.4, order=order)).torque[-1] - exact)
        for step in (2e-3, 1e-3)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_output_does_not_drift(order: int, e12: Robot, smooth: Trajectory) -> None:
    problem = problem_of(e12, smooth, 5e-4, 8.0, order=order)
    motion = motion_of(problem)
    assert output_drift(e12, "tool", motion.arm_position, smooth_circle(problem.time)) < 2e-12  # its own rounding
    assert output_drift(e12, "tool", motion.arm_position, problem.desired) < 5e-15


@pytest.mark.slow
def test_second_order_agrees_with_the_index_one_form(e12: Robot, smooth: Trajectory) -> None:
    problem = problem_of(e12, smooth, 1e-3, 0.3)
    exact = solve_index_one(problem, "LSODA", 1e-9, 1e-12)
    motion = motion_of(problem)
    assert np.max(np.abs(motion.arm_position - exact.arm_position)) < 4e-6
    assert (
        np.max(np.abs(motion.torque - exact.torque)) < 5.0
    )  # of 4000 Nm; the fifth derivative of the path jumps at the start


def test_starts_in_equilibrium_under_gravity() -> None:
    heavy = edited_robot("e12", lambda data: data.update(gravity=[0, 0, -9.81]))
    motion = motion_of(
        problem_of(heavy, tool_trajectory(heavy, CIRCLE, {"type": "quintic", "duration": 1.0}), 1e-3, 0.02)
    )
    state = heavy.equilibrium(motion.arm_position[0])
    np.testing.assert_allclose(motion.torque[0], heavy.holding_torque(state), rtol=1e-7)
    assert np.max(np.abs(motion.motor_velocity[0])) < 1e-9
    assert abs(motion.arm_position[0, 2]) > 1e-3  # the tool hangs on its spring


@pytest.mark.slow
@pytest.mark.parametrize(
    "spring",
    [
        {"cubic": {"linear": 8e4, "cubic": 5e7}},
        {"piecewise_linear": {"knots": [0.002, 0.008], "slopes": [5e4, 9e4, 2e5]}},
    ],
)
def test_nonlinear_gear_springs(spring: dict[str, object], smooth: Trajectory) -> None:
    def stiffen(data: dict[str, list[dict[str, dict[str, dict[str, object]]]]]) -> None:
        for body in data["bodies"][:2]:
            body["directions"]["ry"]["spring"] = spring

    robot = edited_robot("e12", stiffen)
    problem = problem_of(robot, smooth, 5e-4, 0.8)
    motion = motion_of(problem)
    assert output_drift(robot, "tool", motion.arm_position, problem.desired) < 5e-15
    # the spring law itself: torque through gear 1 against its deflection, at the moment of the highest torque
    k = int(np.argmax(np.abs(motion.load[:, 0])))
    deflection = motion.motor_position[k] - motion.arm_position[k, :2]
    rate = np.gradient(motion.motor_position[:, 0] - motion.arm_position[:, 0], 5e-4)[k]
    law = robot.joints[0].direction.spring
    assert motion.load[k, 0] == pytest.approx(float(law.force(deflection[0], 1.0)) + 50 * rate, rel=1e-3)


def test_stiff_gear_torque_is_that_of_a_rigid_axis() -> None:
    emps = load_robot("emps")
    line = joint_trajectory(emps, [0.2], 0.5)
    motion = motion_of(problem_of(emps, line, 1e-3, 0.6))
    rigid = compute_reference(emps, line, FeedforwardSpecification(method="rigid", hold_compensation=False), 1e-3, 0.6)
    np.testing.assert_allclose(motion.motor_position, rigid.motor_position, atol=1e-14)
    np.testing.assert_allclose(motion.torque, rigid.torque, atol=0.01 * np.abs(rigid.torque).max())


def test_motor_side_coordinates_and_damped_arm() -> None:
    four_mass = load_robot("four_mass")
    problem = problem_of(four_mass, joint_trajectory(four_mass, [30.0], 1.5), 5e-4, 1.6, output="tool")
    motion = motion_of(problem)
    assert output_drift(four_mass, "tool", motion.arm_position, problem.desired) < 1e-13
    assert np.all(np.isfinite(motion.torque))


def test_inertial_coupling_is_part_of_the_model() -> None:
    def couple(data: dict[str, object]) -> None:
        data["inertial_coupling"] = True

    coupled, plain = edited_robot("elbow", couple), load_robot("elbow")
    path = joint_trajectory(plain, [0.5, -0.4], 0.6)
    torque, without = (motion_of(problem_of(robot, path, 1e-3, 0.7)).torque for robot in (coupled, plain))
    assert np.max(np.abs(torque - without)) > 0.1
    exact = compute_reference(plain, path, FeedforwardSpecification(method="rigid", hold_compensation=False), 1e-3, 0.7)
    assert np.max(np.abs(without - exact.torque)) < 0.2 * np.abs(exact.torque).max()


@pytest.mark.slow
def test_six_axis_robot_on_its_joints() -> None:
    robot = load_robot("six_axis")
    problem = problem_of(robot, joint_trajectory(robot, [0.3, 0.2, -0.2, 0.4, 0.3, 0.5], 1.0), 5e-4, 1.1)
    motion = motion_of(problem)
    assert output_drift(robot, "joints", motion.arm_position, problem.desired) < 1e-14
    state = robot.equilibrium(motion.arm_position[0])
    np.testing.assert_allclose(motion.torque[0], robot.holding_torque(state), rtol=1e-6, atol=1e-5)


@pytest.mark.slow
def test_large_model_by_the_mass_based_matrix() -> None:
    robot = subdivided_e12(9)
    assert robot.n_arm == 27
    problem = problem_of(robot, joint_trajectory(robot, [0.3, -0.2], 0.5), 5e-4, 0.6, output="joints")
    motion = motion_of(problem)
    assert output_drift(robot, "joints", motion.arm_position, problem.desired) < 1e-14
    coarse = load_robot("e12")
    same = motion_of(problem_of(coarse, joint_trajectory(coarse, [0.3, -0.2], 0.5), 5e-4, 0.6, output="joints"))
    assert np.max(np.abs(motion.torque - same.torque)) < 0.1 * np.abs(same.torque).max()  # inertia spread over pieces


def test_chunks_give_the_same_bits(e12: Robot, circle: Trajectory) -> None:
    problem = problem_of(e12, circle, 5e-4, 0.2)
    whole = motion_of(problem)
    parts = list(feedforward_method("dae").motions(problem, 37))
    assert len(parts) == 11
    np.testing.assert_array_equal(np.concatenate([part.torque for part in parts]), whole.torque)
    np.testing.assert_array_equal(np.concatenate([part.motor_position for part in parts]), whole.motor_position)


def test_stepper_is_built_once(e12: Robot) -> None:
    assert dae_stepper(e12, "tool", 2, 5e-4, True) is dae_stepper(e12, "tool", 2, 5e-4, True)


def test_failure_names_time_and_place(e12: Robot, smooth: Trajectory) -> None:
    class Jumping:
        joints, n_out, output, duration, place = False, 2, "tool", smooth.duration, smooth.place

        def evaluate(self, t: np.ndarray, derivatives: int = 4) -> np.ndarray:
            motion = smooth.evaluate(t, derivatives)
            motion[0, t > 0.1] += 10.0  # far out of reach
            return motion

    problem = FeedforwardProblem(e12, Jumping(), FeedforwardSpecification(zero_dynamics_poses=1), 1e-3, 200)  # type: ignore[arg-type]
    with pytest.raises(
        RunError, match=r"robot e12 found no solution at t = 0\.1010 s, .* of move 1 .* did not converge"
    ):
        motion_of(problem)


def test_output_needs_one_component_per_motor() -> None:
    def two_outputs(data: dict[str, object]) -> None:
        data["outputs"] = {"tool": {"pose": ["x", "y"]}, "joints": {"coordinates": ["body_1.rz"]}}

    robot = edited_robot("two_mass", two_outputs)
    problem = problem_of(robot, joint_trajectory(robot, [0.2], 0.5), 1e-3, 0.5, output="tool")
    with pytest.raises(
        InputError, match=r"output 'tool' of robot two_mass has 2 components, but its motors can control 1"
    ):
        motion_of(problem)
