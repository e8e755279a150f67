from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.trajectory.arc import circle
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.joint_derivatives import OutputDerivatives, cubic_hermite, joint_derivatives
from flexros.trajectory.limits import Limits
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.polynomial import ninth_degree, quintic
from flexros.trajectory.trajectory import JOINTS, Move, Trajectory

if TYPE_CHECKING:
    from tests.trajectory.conftest import TwoLinkArm

ELBOW = np.array([0.0, 0.3])


def smooth_circle(start: FloatArray, angle: float = 0.0) -> Trajectory:
    return Trajectory((Move(circle(start, 0.025, angle), ninth_degree(2 * np.pi, 0.8).held(after=0.1)),), "tool")


def test_joints_give_the_tool_motion_and_all_its_derivatives(arm: TwoLinkArm, start: FloatArray) -> None:
    trajectory, t = smooth_circle(start), np.linspace(0.0, 0.9, 901)
    output = OutputDerivatives.of(arm.gamma())
    motion = joint_derivatives(trajectory, output, ELBOW, t)
    wanted = trajectory.evaluate(t)
    for order, tool in enumerate(output.along(motion)):
        np.testing.assert_allclose(tool, wanted[order], atol=1e-12 * max(1.0, np.max(np.abs(wanted[order]))))


def test_derivatives_agree_with_differences(arm: TwoLinkArm, start: FloatArray) -> None:
    t = np.linspace(0.05, 0.75, 36) + 1e-3
    h = 1e-4
    left, exact, right = (
        joint_derivatives(smooth_circle(start), arm.gamma(), ELBOW, times) for times in (t - h, t, t + h)
    )
    for order in range(1, 5):
        size = np.max(np.abs(exact[order]))
        np.testing.assert_allclose((right[order - 1] - left[order - 1]) / (2 * h), exact[order], atol=2e-5 * size)


def test_positions_agree_with_the_closed_form(arm: TwoLinkArm, start: FloatArray) -> None:
    trajectory, t = smooth_circle(start), np.linspace(0.0, 0.9, 91)
    joints = joint_derivatives(trajectory, arm.gamma(), ELBOW, t, derivatives=0)[0]
    expected = [arm.inverse_kinematics(z, ELBOW) for z in trajectory.evaluate(t, 0)[0]]
    np.testing.assert_allclose(joints, expected, atol=1e-12)


@pytest.mark.parametrize("near", [ELBOW, np.array([-0.3, -0.3])])
def test_configuration_of_the_start_is_kept(arm: TwoLinkArm, start: FloatArray, near: FloatArray) -> None:
    joints = joint_derivatives(smooth_circle(start), arm.gamma(), near, np.linspace(0.0, 0.9, 50), 0)[0]
    assert np.all(np.sign(joints[:, 1]) == np.sign(near[1]))


def test_few_times_far_from_the_start_keep_the_configuration(arm: TwoLinkArm) -> None:
    line = Line(np.array([1.0, 1.5]), np.array([1.0, -1.5]))
    trajectory = Trajectory((Move(line, bang_bang_snap(3.0, Limits(5.0, 50.0, 3000.0, 2e5))),), "tool")
    near = arm.inverse_kinematics(line.start, np.array([0.0, -1.0]))
    joints = joint_derivatives(trajectory, arm.gamma(), near, np.array([trajectory.duration, 0.1]), 0)[0]
    np.testing.assert_allclose(joints[0], arm.inverse_kinematics(line.end, np.array([0.0, -1.0])), atol=1e-11)


def test_fewer_derivatives_are_the_first_of_all(arm: TwoLinkArm, start: FloatArray) -> None:
    t = np.linspace(0.0, 0.9, 20)
    full = joint_derivatives(smooth_circle(start), arm.gamma(), ELBOW, t)
    np.testing.assert_allclose(joint_derivatives(smooth_circle(start), arm.gamma(), ELBOW, t, 2), full[:3], atol=1e-12)


def test_quintic_serves_two_derivatives(arm: TwoLinkArm, start: FloatArray) -> None:
    trajectory = Trajectory((Move(circle(start, 0.025), quintic(2 * np.pi, 0.8)),), "tool")
    assert joint_derivatives(trajectory, arm.gamma(), ELBOW, np.linspace(0, 1, 9), 2).shape == (3, 9, 2)
    with pytest.raises(InputError, match="derivative 4 of a trajectory with the time law quintic"):
        joint_derivatives(trajectory, arm.gamma(), ELBOW, np.zeros(1))


def test_one_time_and_none(arm: TwoLinkArm, start: FloatArray) -> None:
    assert joint_derivatives(smooth_circle(start), arm.gamma(), ELBOW, np.zeros(1)).shape == (5, 1, 2)
    assert joint_derivatives(smooth_circle(start), arm.gamma(), ELBOW, np.zeros(0)).shape == (5, 0, 2)


def test_out_of_reach_names_the_point(arm: TwoLinkArm, start: FloatArray) -> None:
    with pytest.raises(InputError, match=r"(out of reach|singular).* at t = .* % of move 1 .* point \(.*\)"):
        joint_derivatives(smooth_circle(start, np.pi / 2), arm.gamma(), ELBOW, np.linspace(0.0, 0.9, 20))


def test_singular_start_names_the_point(arm: TwoLinkArm) -> None:
    line = Line(np.array([2.2, 0.0]), np.array([2.0, 0.0]))
    trajectory = Trajectory((Move(line, ninth_degree(line.extent, 1.0)),), "tool")
    with pytest.raises(InputError, match=r"singular.* at t = 0.0000 s, 0.0 % of move 1"):
        joint_derivatives(trajectory, arm.gamma(), np.array([0.0, 0.0]), np.zeros(1))


def test_joints_that_hardly_move_the_tool_are_refused() -> None:
    q = ca.SX.sym("q", 2)
    parallel = ca.Function("parallel", [q], [ca.vertcat(q[0], q[0] + 1e-8 * q[1])])
    line = Line(np.zeros(2), np.ones(2))
    trajectory = Trajectory((Move(line, ninth_degree(line.extent, 1.0)),), "tool")
    with pytest.raises(
        InputError, match="passes a singularity of the robot at t = 0.0000 s, .* allowed are paths on which"
    ):
        joint_derivatives(trajectory, parallel, np.zeros(2), np.linspace(0.0, 1.0, 5))


def with_gap(size: float) -> tuple[Trajectory, ca.Function]:
    """A motion of one joint whose output jumps by a gap [m] just at the point of t = 0.505 s, so that none gives it."""
    trajectory = Trajectory((Move(Line(np.zeros(1), np.ones(1)), ninth_degree(1.0, 1.0)),), "tool")
    at = trajectory.evaluate(np.array([0.505]), 0)[0, 0, 0]
    q = ca.SX.sym("q")
    return trajectory, ca.Function("gap", [q], [q + 0.5 * size * ca.if_else(q >= at, 1.0, -1.0)])


def test_positions_are_as_exact_as_a_rough_output_function_allows() -> None:
    trajectory, gamma = with_gap(2e-11)
    t = np.linspace(0.0, 1.0, 201)
    joints = joint_derivatives(trajectory, gamma, np.zeros(1), t, 0)
    np.testing.assert_allclose(joints, trajectory.evaluate(t, 0), atol=4e-11)


def test_unreachable_point_is_named() -> None:
    trajectory, gamma = with_gap(2e-8)
    with pytest.raises(InputError, match="out of reach or singular at t = 0.5050 s, .*"):
        joint_derivatives(trajectory, gamma, np.zeros(1), np.linspace(0.0, 1.0, 201), 0)


def test_tool_motion_of_a_joint_motion(arm: TwoLinkArm) -> None:
    trajectory = Trajectory((Move(JointMove(ELBOW, np.array([0.5, 0.9])), ninth_degree(1.0, 1.0)),), JOINTS)
    t, h = np.linspace(0.05, 0.95, 40), 1e-4
    output = OutputDerivatives.of(arm.gamma())
    left, exact, right = (output.along(trajectory.evaluate(times)) for times in (t - h, t, t + h))
    np.testing.assert_allclose(exact[0], [arm.forward(q) for q in trajectory.evaluate(t, 0)[0]], atol=1e-14)
    for order in range(1, 5):
        size = np.max(np.abs(exact[order]))
        np.testing.assert_allclose((right[order - 1] - left[order - 1]) / (2 * h), exact[order], atol=2e-5 * size)


def test_joint_motion_is_passed_on(arm: TwoLinkArm) -> None:
    t = np.linspace(0.0, 1.0, 9)
    joints = Trajectory((Move(JointMove(ELBOW, np.array([0.5, 0.9])), ninth_degree(1.0, 1.0)),), JOINTS)
    np.testing.assert_array_equal(joint_derivatives(joints, arm.gamma(), ELBOW, t), joints.evaluate(t))


def test_sizes_must_agree(arm: TwoLinkArm, start: FloatArray) -> None:
    q = ca.SX.sym("q", 3)
    three = ca.Function("three", [q], [q[:2]])
    with pytest.raises(InputError, match="has 2 coordinates, the output function 2 for 3 joints, .* choose an output"):
        joint_derivatives(smooth_circle(start), three, np.zeros(3), np.zeros(1))


def test_output_function_with_parameters_is_refused() -> None:
    q, p = ca.SX.sym("q", 2), ca.SX.sym("p")
    with pytest.raises(InputError, match="output function f has 2 inputs and 1 outputs, allowed is one vector"):
        OutputDerivatives.of(ca.Function("f", [q, p], [q * p]))


def test_interpolation_equals_scipy_bit_for_bit() -> None:
    rng = np.random.default_rng(1)
    grid = np.concatenate([[0.0], np.cumsum(rng.uniform(0.005, 0.01, 90))])
    values, slopes = rng.normal(size=(2, grid.size, 6))
    t = np.concatenate([rng.permutation(np.linspace(0.0, grid[-1], 5000)), grid])
    np.testing.assert_array_equal(cubic_hermite(grid, values, slopes, t), CubicHermiteSpline(grid, values, slopes)(t))
