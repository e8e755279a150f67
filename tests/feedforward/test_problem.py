from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import joint_trajectory, problem_of, smooth_circle


def test_desired_output_is_that_of_the_trajectory(e12: Robot, smooth: Trajectory) -> None:
    problem = problem_of(e12, smooth, 1e-3, 1.0)
    assert problem.output == "tool"
    np.testing.assert_allclose(problem.desired, smooth_circle(problem.time), atol=2e-12)


def test_joint_trajectory_gives_the_output_of_the_rigid_arm(e12: Robot) -> None:
    problem = problem_of(e12, joint_trajectory(e12, [0.2, 0.1], 0.5), 1e-3, 0.6)
    assert problem.output == "tool"
    np.testing.assert_allclose(problem.desired[-1], e12.forward_kinematics([0.2, 0.4, 0.0]), atol=1e-13)
    np.testing.assert_allclose(problem.rigid_start, e12.home, atol=1e-14)


def test_motion_of_the_gears_is_computed_once(e12: Robot, smooth: Trajectory) -> None:
    problem = problem_of(e12, smooth, 1e-3, 0.2)
    motion, position = problem.gear_motion(2), problem.gear_motion(0)
    assert np.shares_memory(motion, position)
    np.testing.assert_array_equal(position, problem_of(e12, smooth, 1e-3, 0.2).gear_motion(0))
    assert problem.gear_motion(4).shape == (5, *motion.shape[1:])


def test_trajectory_must_start_at_rest(e12: Robot, smooth: Trajectory) -> None:
    class Moving:
        joints, n_out, output, duration = False, 2, "tool", smooth.duration

        def evaluate(self, t: np.ndarray, derivatives: int = 4) -> np.ndarray:
            motion = smooth.evaluate(t, derivatives)
            motion[1] += 0.25
            return motion

    problem = problem_of(e12, Moving(), 1e-3, 0.1)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"starts with a speed of 0\.25 .* but feedforward starts from rest"):
        _ = problem.desired


def test_wrong_number_of_joints(e12: Robot) -> None:
    two_mass = load_robot("two_mass")
    problem = problem_of(e12, joint_trajectory(two_mass, [0.2], 0.5), 1e-3, 0.1)
    with pytest.raises(
        InputError, match=r"moves 1 joints, but robot e12 has 2 motors; give every point one value per motor"
    ):
        problem.gear_motion(0)
