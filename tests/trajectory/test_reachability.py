from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.trajectory.arc import circle
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.joint_derivatives import OutputDerivatives
from flexros.trajectory.limits import Limits
from flexros.trajectory.line import Line
from flexros.trajectory.polynomial import ninth_degree
from flexros.trajectory.reachability import Reachability, check_reachable, is_reachable
from flexros.trajectory.trajectory import Move, Trajectory
from tests.trajectory.conftest import TwoLinkArm

ELBOW = np.array([0.0, 0.3])


def circle_test(start: FloatArray, angle: float) -> Trajectory:
    law = bang_bang_snap(2 * np.pi, Limits(20.0, 600.0, 36000.0, 2.16e6))
    return Trajectory((Move(circle(start, 0.025, angle), law),), "tool")


def check(arm: TwoLinkArm, trajectory: Trajectory, **options: object) -> Reachability:
    return check_reachable(trajectory, arm.inverse_kinematics, arm.jacobian, ELBOW, **options)  # type: ignore[arg-type]


def test_inward_circle_is_reachable(arm: TwoLinkArm, start: FloatArray) -> None:
    reached = check(arm, circle_test(start, 0.0))
    np.testing.assert_allclose(reached.joints[0], ELBOW, atol=1e-11)
    np.testing.assert_allclose(reached.joints[-1], ELBOW, atol=1e-11)
    around = circle(start, 0.025).derivatives(np.linspace(0.0, 2 * np.pi, 2001), 0)[0]
    sizes = np.linalg.svd([arm.jacobian(arm.inverse_kinematics(z, ELBOW)) for z in around], compute_uv=False)
    ratios = sizes[:, 1] / np.maximum.accumulate(sizes[:, 0])
    assert reached.smallest_singular_value == pytest.approx(min(ratios), rel=1e-4)
    assert reached.nearest_singularity.percent == pytest.approx(100.0 * np.argmin(ratios) / 2000, abs=0.5)
    assert reached.joints.shape == (reached.time.size, 2)


def test_circle_with_start_angle_of_90_degrees_meets_the_singularity(arm: TwoLinkArm, start: FloatArray) -> None:
    with pytest.raises(
        InputError,
        match=r"the trajectory passes a singularity of the robot at t = 0\.\d+ s, \d+\.\d % of move 1 \(path "
        r"parameter .* "
        r"rad\), point \(2\.1\d+, -0\.[34]\d+\): the smallest singular value of the Jacobian is 0.0\d+ of the "
        r"largest, allowed are at least 0.02; move the path away from there",
    ):
        check(arm, circle_test(start, np.pi / 2), singular_value=0.02)


def test_the_same_circle_is_out_of_reach_behind_it(arm: TwoLinkArm, start: FloatArray) -> None:
    with pytest.raises(
        InputError,
        match=r"the trajectory is out of reach at t = .* % of move 1 .* point \(.*\): the point is 2.20\d+ m away, "
        r".*; move "
        "the start, turn the path or make it smaller",
    ):
        check(arm, circle_test(start, np.pi / 2), singular_value=0.0)


def test_place_out_of_reach_is_where_the_path_leaves_the_reach(arm: TwoLinkArm) -> None:
    line = Line(np.array([2.0, 0.0]), np.array([2.3, 0.0]))
    trajectory = Trajectory((Move(line, ninth_degree(line.extent, 1.0)),), "tool")
    with pytest.raises(InputError, match=r"6[67]\.\d % of move 1 \(path parameter 0.20\d* m\), point \(2.20\d*, 0\)"):
        check(arm, trajectory, singular_value=0.0)


def test_line_through_the_folded_arm_jumps(arm: TwoLinkArm) -> None:
    def flipping(target: FloatArray, near: FloatArray) -> FloatArray:
        return arm.inverse_kinematics(target, np.array([0.0, 1.0 if target[0] > 1.0 else -1.0]))

    line = Line(np.array([1.5, 0.0]), np.array([0.6, 0.0]))
    trajectory = Trajectory((Move(line, ninth_degree(line.extent, 1.0)),), "tool")
    with pytest.raises(
        InputError, match=r"would jump to another configuration at .* point \(0.99\d*, 0\): joint 2 changes by"
    ):
        check_reachable(trajectory, flipping, arm.jacobian, ELBOW)


def test_inverse_kinematics_without_finite_solution_counts_as_out_of_reach(arm: TwoLinkArm, start: FloatArray) -> None:
    with pytest.raises(InputError, match="out of reach at t = 0.0000 s, .* has no finite solution"):
        check_reachable(circle_test(start, 0.0), lambda _target, _near: np.full(2, np.nan), arm.jacobian, ELBOW)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_verdict_does_not_depend_on_the_size_of_the_arm(start: FloatArray, scale: float) -> None:
    arm = TwoLinkArm(scale, 1.2 * scale)
    law = bang_bang_snap(2 * np.pi, Limits(20.0, 600.0, 36000.0, 2.16e6))
    inward, outward = (
        Trajectory((Move(circle(scale * start, scale * radius, angle), law),), "tool")
        for radius, angle in ((0.025, 0.0), (0.05, np.pi))
    )
    assert check(arm, inward).smallest_singular_value > 0.05
    with pytest.raises(InputError, match="passes a singularity of the robot|is out of reach"):
        check(arm, outward)


def test_one_joint_is_singular_where_it_moves_its_output_no_more() -> None:
    line = Line(np.zeros(1), np.ones(1))  # height of a link of 1 m, which stands upright at the end
    trajectory = Trajectory((Move(line, ninth_degree(line.extent, 1.0)),), "tool")
    with pytest.raises(InputError, match=r"passes a singularity of the robot at .* point \((0\.99\d*|1)\)"):
        check_reachable(trajectory, lambda z, _near: np.arcsin(z), lambda q: np.cos(q)[:, None], np.zeros(1))


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.8, 1.2, np.pi / 2])
@pytest.mark.parametrize("singular_value", [0.005, 0.1, 0.3])
def test_all_points_at_once_give_the_same_verdict(
    arm: TwoLinkArm, start: FloatArray, angle: float, singular_value: float
) -> None:
    trajectory = circle_test(start, angle)
    try:
        reached = check(arm, trajectory, singular_value=singular_value)
    except InputError:
        reached = None
    found = is_reachable(trajectory, OutputDerivatives.of(arm.gamma()), ELBOW, singular_value=singular_value)
    assert found == (reached is not None)


def test_few_points_on_a_long_path_are_left_to_the_check_point_by_point(arm: TwoLinkArm) -> None:
    line = Line(np.array([2.0, 0.0]), np.array([1.9, 0.0]))
    kinematics = OutputDerivatives.of(arm.gamma())
    short, long = (Trajectory((Move(line, ninth_degree(line.extent, time)),), "tool") for time in (1.0, 10.0))
    assert is_reachable(short, kinematics, ELBOW)
    assert not is_reachable(long, kinematics, ELBOW)
