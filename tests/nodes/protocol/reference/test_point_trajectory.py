"""A trajectory of points, evaluated at one instant at a time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from flexros_nodes.protocol.reference.point_trajectory import PointTrajectory

RNG = np.random.default_rng(6)
TIMES = np.array([1_000_000_000, 1_003_000_000, 1_010_000_000], dtype=np.int64)
ROWS = RNG.standard_normal((3, 6))


@pytest.mark.parametrize("stamp", [1_000_000_000, 1_001_200_000, 1_003_000_000, 1_009_999_999, 1_010_000_000])
def test_points_with_velocities_are_joined_by_hermite_cubics(stamp: int) -> None:
    spline = CubicHermiteSpline((TIMES - TIMES[0]) * 1e-9, ROWS[:, :2], ROWS[:, 2:4])
    t = (stamp - TIMES[0]) * 1e-9
    row = PointTrajectory(TIMES, ROWS, smooth=True).row(stamp)
    assert row[:2] == pytest.approx(spline(t), abs=1e-12)
    assert row[2:4] == pytest.approx(spline.derivative()(t), rel=1e-9, abs=1e-9)
    assert row[4:] == pytest.approx([np.interp(stamp, TIMES, ROWS[:, i]) for i in (4, 5)])


def test_points_without_velocities_are_joined_by_lines() -> None:
    row = PointTrajectory(TIMES, ROWS, smooth=False).row(1_004_750_000)
    assert row[:2] == pytest.approx(ROWS[1, :2] + 0.25 * (ROWS[2, :2] - ROWS[1, :2]))
    assert row[2:4] == pytest.approx((ROWS[2, :2] - ROWS[1, :2]) / 0.007)


@pytest.mark.parametrize(("stamp", "point"), [(900_000_000, 0), (1_010_000_001, 2), (9_000_000_000, 2)])
def test_it_rests_before_its_begin_and_after_its_end(stamp: int, point: int) -> None:
    row = PointTrajectory(TIMES, ROWS, smooth=True).row(stamp)
    assert row.tolist() == [*ROWS[point, :2], 0.0, 0.0, *ROWS[point, 4:]]


def test_single_point_is_a_rest() -> None:
    row = PointTrajectory(TIMES[:1], ROWS[:1], smooth=True).row(1_000_000_000)
    assert row.tolist() == [*ROWS[0, :2], 0.0, 0.0, *ROWS[0, 4:]]


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("stamp", [1_001_200_000, 1_009_999_999])
def test_links_move_as_the_motors_with_the_acceleration_between_the_points(stamp: int, smooth: bool) -> None:
    row = PointTrajectory(TIMES, ROWS, smooth=smooth, links=True).row(stamp)
    assert row.shape == (16,)
    assert np.array_equal(row[:6], PointTrajectory(TIMES, ROWS, smooth=smooth).row(stamp))
    position, velocity, acceleration, jerk, snap = row[6:].reshape(5, 2)
    spline = CubicHermiteSpline((TIMES - TIMES[0]) * 1e-9, ROWS[:, :2], ROWS[:, 2:4])
    bend = spline.derivative(2)((stamp - TIMES[0]) * 1e-9) if smooth else np.zeros(2)
    assert np.array_equal([position, velocity], row[:4].reshape(2, 2))
    assert acceleration == pytest.approx(bend, rel=1e-9, abs=1e-6)
    assert not np.any([jerk, snap])


def test_links_rest_where_the_motors_rest() -> None:
    row = PointTrajectory(TIMES, ROWS, smooth=True, links=True).row(9_000_000_000)
    assert row[6:].tolist() == [*ROWS[2, :2], *[0.0] * 8]
