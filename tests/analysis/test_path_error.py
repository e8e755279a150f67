from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.analysis.path_error import path_error
from flexros.analysis.path_performance import path_performance
from flexros.errors import InputError
from flexros.logs.time_series import PoseSeries

RADIUS = 0.025


def stamps(n, sample_time=5e-4):
    return 1_000_000_000 + np.rint(np.arange(n) * sample_time * 1e9).astype(np.int64)


def series(points, stamp=None, orientation=None):
    n = len(points)
    identity = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    return PoseSeries(
        stamps(n) if stamp is None else stamp, "base", points, identity if orientation is None else orientation
    )


def ring(angle, half_x=RADIUS, half_z=RADIUS):
    return np.column_stack([half_x * np.cos(angle), np.zeros_like(angle), half_z * np.sin(angle)]) + np.array(
        [2.1, 0.0, -0.3]
    )


def test_ellipse_around_a_circle_has_the_difference_of_the_half_axes_as_error():
    angle = np.linspace(0.0, 2 * np.pi, 801)
    error = path_error(series(ring(angle, RADIUS + 3e-4)), series(ring(angle)))
    assert error.shape == "circle of radius 25 mm"
    assert error.path.maximum == pytest.approx(3e-4, rel=1e-9)
    exact = np.abs(np.hypot((RADIUS + 3e-4) * np.cos(angle), RADIUS * np.sin(angle)) - RADIUS)
    np.testing.assert_allclose(error.distance, exact, atol=1e-12)
    assert error.path.rms == pytest.approx(np.sqrt(np.mean(exact**2)), rel=1e-9)


def test_time_and_place_of_the_largest_error_are_reported():
    angle = np.linspace(0.0, 2 * np.pi, 801)
    bump = 1e-4 * np.exp(-(((angle - np.pi / 2) / 0.1) ** 2))
    error = path_error(series(ring(angle, RADIUS + bump, RADIUS + bump)), series(ring(angle)))
    assert error.path.time_of_maximum == pytest.approx(200 * 5e-4)
    assert error.path.position_of_maximum == pytest.approx(RADIUS * np.pi / 2, rel=1e-6)


def test_a_delay_is_a_time_synchronised_error_but_no_path_error():
    angle = np.linspace(0.0, 2 * np.pi, 801)
    late = angle - 0.01
    error = path_error(series(ring(late)), series(ring(angle)))
    assert error.path.maximum == pytest.approx(0.0, abs=1e-12)
    assert error.synchronised.maximum == pytest.approx(2 * RADIUS * np.sin(0.005), rel=1e-9)


def test_reference_of_a_lower_rate_is_interpolated_linearly():
    t = np.arange(801) * 5e-4
    line = np.column_stack([0.3 * t, 0.1 * t, 0 * t])
    error = path_error(series(line + np.array([0.0, 0.0, 2e-4])), series(line[::8], stamps(101, 4e-3)))
    assert error.synchronised.maximum == pytest.approx(2e-4, rel=1e-9)
    assert error.synchronised.count == 801


def test_only_the_time_that_both_share_counts():
    angle = np.linspace(0.0, 2 * np.pi, 801)
    points = ring(angle)
    error = path_error(series(points), series(points[100:], stamps(801)[100:]))
    assert error.path.count == 701
    assert error.run.time[0] == pytest.approx(0.05)


def test_a_planar_robot_uses_the_components_that_move():
    angle = np.linspace(0.0, 2 * np.pi, 201)
    assert path_error(series(ring(angle)), series(ring(angle))).axes == ("x", "z")


def test_components_that_do_not_count_are_left_out():
    angle = np.linspace(0.0, 2 * np.pi, 201)
    noisy = ring(angle) + np.outer(np.sin(7 * angle), [0.0, 5e-5, 0.0])
    assert path_error(series(noisy), series(ring(angle))).path.maximum > 1e-9
    error = path_error(series(noisy), series(ring(angle)), axes=("x", "z"))
    assert error.path.maximum == pytest.approx(0.0, abs=1e-12)


def test_error_across_the_plane_counts_for_a_spatial_robot():
    angle = np.linspace(0.0, 2 * np.pi, 201)
    error = path_error(series(ring(angle) + np.array([0.0, 3e-4, 0.0])), series(ring(angle)))
    assert error.path.maximum == pytest.approx(3e-4, rel=1e-9)


def test_orientation_error_is_the_angle_between_attained_and_commanded():
    angle = np.linspace(0.0, 1.0, 101)
    goal = Rotation.from_euler("y", angle[:, None])
    actual = goal * Rotation.from_euler("x", 2e-3)
    error = path_error(series(ring(angle), None, actual.as_quat()), series(ring(angle), None, goal.as_quat()))
    assert error.orientation is not None
    assert error.orientation.maximum == pytest.approx(2e-3, rel=1e-6)


def test_the_sign_of_a_quaternion_says_nothing():
    t = np.linspace(0.0, 1.0, 334)
    line = np.column_stack([t, 0 * t, 0 * t])
    goal = Rotation.from_euler("z", 0.5 + t[:, None])
    actual = (Rotation.from_rotvec([0.0, 2e-3, 0.0]) * goal).as_quat()
    actual[::2] *= -1.0
    error = path_error(series(line, None, actual), series(line, None, goal.as_quat()))
    np.testing.assert_allclose(path_performance([error.run]).orientation_accuracy, [0.0, 2e-3, 0.0], atol=1e-6)


def test_a_reference_at_identity_commands_no_orientation():
    angle = np.linspace(0.0, 1.0, 101)
    turned = Rotation.from_euler("y", angle[:, None]).as_quat()
    assert path_error(series(ring(angle), None, turned), series(ring(angle))).orientation is None


@pytest.mark.parametrize("side", ["pose", "reference"])
@pytest.mark.parametrize("broken", [np.zeros(4), np.full(4, np.nan)])
def test_one_orientation_that_is_none_leaves_the_position_error(side, broken):
    angle = np.linspace(0.0, 1.0, 101)
    turned = Rotation.from_euler("y", angle[:, None]).as_quat()
    spoilt = turned.copy()
    spoilt[50] = broken
    pose, reference = (series(ring(angle), None, spoilt if name == side else turned) for name in ("pose", "reference"))
    error = path_error(pose, reference)
    assert error.orientation is None
    assert error.path.maximum == pytest.approx(0.0, abs=1e-12)


def test_stamps_since_1970_keep_their_nanoseconds():
    t = np.arange(401) * 5e-4
    line = np.column_stack([t, 0 * t, 0 * t])
    epoch = 1_780_000_000_000_000_000
    error = path_error(series(line, stamps(401) + epoch), series(line, stamps(401) + epoch))
    assert error.synchronised.maximum < 1e-15
    assert error.run.time[1] == pytest.approx(5e-4, abs=1e-15)


def test_series_without_common_time_are_refused():
    points = ring(np.linspace(0, 1, 11))
    with pytest.raises(InputError, match=r"tool_pose has stamps from 1\.000 to .* they must share a time"):
        path_error(series(points), series(points, stamps(11) + 10**10))


def test_a_position_that_is_no_number_is_named_with_its_time():
    points = ring(np.linspace(0, 1, 11))
    broken = points.copy()
    broken[4, 0] = np.nan
    with pytest.raises(InputError, match=r"tool_pose has a position that is not finite near 0\.0020 s"):
        path_error(series(broken), series(points))


def test_unknown_axes_are_refused():
    points = ring(np.linspace(0, 1, 11))
    with pytest.raises(InputError, match="axes u were given .* use one or more of x, y, z"):
        path_error(series(points), series(points), axes=("u",))


def turning(n, sample_time=5e-4, late=0.0):
    """A tool on a Lissajous figure that turns, in all three directions, every 2 s."""
    t = np.pi * (np.arange(n) * sample_time - late)
    points = np.column_stack([0.1 * np.cos(3 * t), 0.05 * np.sin(5 * t), 0.1 * np.sin(4 * t)])
    goal = Rotation.from_euler("xz", np.column_stack([0.3 + 0.2 * np.sin(3 * t), 0.4 * np.cos(2 * t)])).as_quat()
    return series(points, stamps(n, sample_time), goal)


ARRAYS = ("nearest", "position", "distance", "time_difference", "angle")
ARRAYS_OF_RUN = ("time", "commanded", "attained", "commanded_orientation", "attained_orientation")


@pytest.mark.parametrize("rate", [1, 3])
def test_blocks_of_a_long_log_change_no_bit(monkeypatch, rate):
    attained, commanded = turning(3001, late=0.003), turning(1 + 3000 // rate, rate * 5e-4)
    whole = path_error(attained, commanded)
    assert whole.orientation is not None
    monkeypatch.setattr("flexros.analysis.path_error.AT_ONCE", 7)
    monkeypatch.setattr("flexros.analysis.path_geometry._ROWS_AT_ONCE", 7)
    blocks = path_error(attained, commanded)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(blocks, name), getattr(whole, name))
    for name in ARRAYS_OF_RUN:
        np.testing.assert_array_equal(getattr(blocks.run, name), getattr(whole.run, name))
    assert blocks.as_dict() == whole.as_dict()


@pytest.mark.parametrize("axes", [None, ("x", "z")])
def test_the_log_itself_is_not_changed(axes):
    attained, commanded = turning(801, late=0.003), turning(801)
    before = [array.copy() for pose in (attained, commanded) for array in (pose.position, pose.orientation)]
    path_error(attained, commanded, axes=axes)
    after = [array for pose in (attained, commanded) for array in (pose.position, pose.orientation)]
    for old, new in zip(before, after, strict=True):
        np.testing.assert_array_equal(new, old)


@pytest.mark.slow
def test_memory_of_a_long_log_is_little_more_than_the_result(monkeypatch):
    monkeypatch.setattr("flexros.analysis.path_error.AT_ONCE", 2000)
    monkeypatch.setattr("flexros.analysis.path_geometry._ROWS_AT_ONCE", 2000)
    monkeypatch.setattr("flexros.analysis.path_geometry._MOST_DISTANCES", 16_000)
    n = 60_000
    attained, commanded = turning(n, late=0.003), turning(n)
    tracemalloc.start()
    error = path_error(attained, commanded)
    largest = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    own = [getattr(error, name) for name in ARRAYS] + [error.run.time, error.run.commanded]
    result = sum(array.nbytes for array in own if array is not None)
    assert largest < 3.0 * result  # 2.2; 4.2 with copies of the log and temporary arrays of its length
