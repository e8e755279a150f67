from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.trajectory.arc import circle
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.limits import Limits
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.polynomial import ninth_degree, quintic
from flexros.trajectory.sequence import Sequence
from flexros.trajectory.trajectory import JOINTS, Move, Trajectory

CIRCLE = Limits(20.0, 600.0, 36000.0, 2.16e6)


@pytest.fixture
def circle_test(start: FloatArray) -> Trajectory:
    return Trajectory((Move(circle(start, 0.025), bang_bang_snap(2 * np.pi, CIRCLE)),), "tool")


def there_and_back() -> Trajectory:
    path = Sequence([[0.0, 0.0], [1.0, 0.2], [0.8, 1.0]], 0.3)
    law = ninth_degree(path.extent, 0.7).held(0.1, 0.2)
    return Trajectory((Move(path, law), Move(path, law.mirrored())), "tool")


@pytest.mark.parametrize("time", [0.013, 0.045, 0.2, 0.33, 0.36])
def test_derivatives_of_the_circle_test_agree_with_differences(circle_test: Trajectory, time: float) -> None:
    h = 1e-5
    left, exact, right = np.moveaxis(circle_test.evaluate(np.array([time - h, time, time + h])), 1, 0)
    for order in range(1, 5):
        difference = (right[order - 1] - left[order - 1]) / (2 * h)
        np.testing.assert_allclose(difference, exact[order], rtol=1e-3, atol=1e-6 * 10.0 ** (2 * order))


def test_derivatives_agree_with_differences_in_corners() -> None:
    trajectory = there_and_back()
    h, t = 1e-5, np.linspace(0.15, 1.85, 171) + 1.234e-3
    left, exact, right = (trajectory.evaluate(times) for times in (t - h, t, t + h))
    for order in range(1, 5):
        size = np.max(np.abs(exact[order]))
        np.testing.assert_allclose((right[order - 1] - left[order - 1]) / (2 * h), exact[order], atol=3e-5 * size)


def test_peaks_of_the_circle_test(circle_test: Trajectory) -> None:
    values = circle_test.evaluate(np.linspace(0.0, circle_test.duration, 20001), 2)
    assert np.max(np.linalg.norm(values[1], axis=1)) == pytest.approx(0.5, rel=1e-9)
    assert np.max(np.linalg.norm(values[2], axis=1)) == pytest.approx(15.23, abs=0.01)


def test_every_sample_is_on_the_circle(circle_test: Trajectory, start: FloatArray) -> None:
    position = circle_test.evaluate(np.linspace(-0.1, 0.5, 1201), 0)[0]
    np.testing.assert_allclose(np.linalg.norm(position - (start - [0.025, 0.0]), axis=1), 0.025, atol=1e-15)


def test_start_and_end_are_held(circle_test: Trajectory, start: FloatArray) -> None:
    values = circle_test.evaluate(np.array([-1.0, circle_test.duration, 7.0]))
    np.testing.assert_allclose(values[0], np.tile(start, (3, 1)), atol=1e-15)
    np.testing.assert_array_equal(values[1:], 0.0)


def test_times_may_come_in_any_order() -> None:
    trajectory = there_and_back()
    t = np.random.default_rng(3).uniform(0.0, trajectory.duration, 50)
    for k in range(50):
        np.testing.assert_array_equal(trajectory.evaluate(t)[:, k], trajectory.evaluate(t[k : k + 1])[:, 0])


def test_the_way_back_is_the_way_there() -> None:
    trajectory = there_and_back()
    t = np.linspace(0.0, 0.999, 100)
    np.testing.assert_allclose(trajectory.evaluate(t, 0)[0], trajectory.evaluate(2.0 - t, 0)[0], atol=1e-14)
    assert trajectory.duration == pytest.approx(2.0)
    np.testing.assert_array_equal(trajectory.end, [0.0, 0.0])


def test_quintic_gives_three_derivatives_and_refuses_the_fourth() -> None:
    trajectory = Trajectory((Move(Line(np.zeros(2), np.ones(2)), quintic(np.sqrt(2.0), 1.0)),), "tool")
    assert trajectory.bounded_derivatives == 3
    assert trajectory.evaluate(np.array([0.0]), 3)[3, 0] == pytest.approx([60.0, 60.0])
    with pytest.raises(
        InputError,
        match="derivative 4 of a trajectory with the time law quintic was requested, which has only 3 .* choose "
        "ninth_degree",
    ):
        trajectory.evaluate(np.array([0.5]))


@pytest.mark.parametrize("derivatives", [-1, 5])
def test_number_of_derivatives_is_checked(circle_test: Trajectory, derivatives: int) -> None:
    with pytest.raises(InputError, match=f"{derivatives} derivatives were requested, allowed are 0 to 4"):
        circle_test.evaluate(np.zeros(1), derivatives)


def test_place_names_time_share_and_point(circle_test: Trajectory) -> None:
    place = circle_test.place(0.5 * circle_test.duration)
    assert place.percent == pytest.approx(50.0)
    assert str(place) == "t = 0.1904 s, 50.0 % of move 1 (path parameter 3.14159 rad), point (2.0964, -0.354624)"


def test_moves_must_meet() -> None:
    one = Move(Line(np.zeros(2), np.ones(2)), ninth_degree(np.sqrt(2.0), 1.0))
    with pytest.raises(
        InputError, match=r"move 1 of the trajectory ends at \(1, 1\) and move 2 begins at \(0, 0\), allowed"
    ):
        Trajectory((one, one), "tool")
    with pytest.raises(InputError, match="move 2 begins at"):
        Trajectory((one, Move(JointMove(np.ones(3), np.zeros(3)), ninth_degree(1.0, 1.0))), "tool")


def test_time_law_must_fit_the_path() -> None:
    with pytest.raises(
        InputError, match="the time law ends at 2 m, allowed is at most the path's extent 1; make the time"
    ):
        Move(Line(np.zeros(2), np.array([1.0, 0.0])), ninth_degree(2.0, 1.0))


def test_no_move_is_refused() -> None:
    with pytest.raises(InputError, match="the trajectory has no move, allowed is one or more; add a move"):
        Trajectory((), "tool")


def test_joint_trajectories_are_labelled() -> None:
    move = Move(JointMove(np.zeros(2), np.ones(2)), ninth_degree(1.0, 1.0))
    assert Trajectory((move,), JOINTS).joints
    assert not Trajectory((move,), "tool").joints


def test_checks_look_at_repeated_moves_once() -> None:
    move = Move(circle(np.zeros(2), 1.0), ninth_degree(2 * np.pi, 1.0))
    assert Trajectory((move,) * 50, "tool").sample_times(100).size == 100


def test_delayed_trajectory_rests_longer_and_moves_alike() -> None:
    path = JointMove(np.array([0.1]), np.array([0.6]))
    move = Trajectory((Move(path, ninth_degree(path.extent, 0.8).held(before=0.25)),), JOINTS)
    later = move.delayed(0.5)
    assert (move.rest_before, later.rest_before) == pytest.approx((0.25, 0.75))
    assert later.duration == pytest.approx(move.duration + 0.5)
    t = np.linspace(0.0, 1.2, 7)
    np.testing.assert_allclose(later.evaluate(t + 0.5, 4), move.evaluate(t, 4), atol=1e-9)
    assert Trajectory.at_rest(np.zeros(1)).rest_before == 1.0
