from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexros.errors import InputError
from flexros.trajectory.sequence import Sequence

ELBOW = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 10_000), st.integers(2, 6), st.floats(0.01, 0.5))
def test_four_derivatives_are_continuous_where_zones_begin_and_end(seed: int, corners: int, share: float) -> None:
    points = np.cumsum(np.random.default_rng(seed).uniform(0.2, 1.0, size=(corners + 2, 3)), axis=0)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    zones = share * np.minimum(lengths[:-1], lengths[1:])
    path = Sequence(list(points), zones)
    for knot, zone in zip(path.knots[1:-1], zones, strict=True):
        for edge in (knot - zone, knot + zone):
            step = 1e-7 * zone
            jump = np.diff(path.derivatives(np.array([edge - step, edge + step])), axis=1)[:, 0]
            inside = path.derivatives(np.linspace(knot - zone, knot + zone, 101)[1:-1])
            for order in range(5):
                assert np.max(np.abs(jump[order])) <= 1e-5 * (np.max(np.abs(inside[order])) + 1e-9)


def test_straight_parts_lie_on_the_segments() -> None:
    path = Sequence(ELBOW, 0.25)
    np.testing.assert_allclose(path.derivatives(np.array([0.5, 2.0]), 1)[:, 0], [[0.5, 0.0], [1.0, 0.0]])
    np.testing.assert_allclose(path.derivatives(np.array([2.0]), 1)[:, 0], [[1.0, 1.0], [0.0, 1.0]])


def test_corner_is_passed_at_the_stated_distance() -> None:
    path = Sequence(ELBOW, 0.25)
    distance = np.linalg.norm(path.point_at(1.0) - [1.0, 0.0])
    assert distance == pytest.approx(0.13671875 * 0.25 * np.sqrt(2.0), rel=1e-12)


def test_path_leaves_the_segments_only_inside_the_zones() -> None:
    path = Sequence(ELBOW, 0.25)
    s = np.linspace(0.0, path.extent, 3001)
    p = path.derivatives(s, 0)[0]
    off = np.minimum(np.abs(p[:, 1]), np.abs(p[:, 0] - 1.0)) > 1e-12
    assert np.all(np.linalg.norm(p[off] - [1.0, 0.0], axis=1) <= 0.25)
    assert np.count_nonzero(off) > 100


def test_speed_in_corners_never_exceeds_that_of_straight_parts() -> None:
    path = Sequence(ELBOW, [0.5])
    slope = path.derivatives(np.linspace(0.0, path.extent, 3001), 1)[1]
    assert np.max(np.linalg.norm(slope, axis=1)) <= 1.0 + 1e-12


def test_a_straight_corner_stays_straight() -> None:
    path = Sequence([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]], 0.3)
    values = path.derivatives(np.linspace(0.0, 3.0, 101))
    np.testing.assert_allclose(values[0, :, 0], np.linspace(0.0, 3.0, 101), atol=1e-15)
    np.testing.assert_allclose(values[2:], 0.0, atol=1e-10)


def test_joints_are_measured_by_all_coordinates() -> None:
    path = Sequence([[0.0] * 4, [0.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 2.0]], 0.1, joints=True)
    assert path.extent == 3.0
    assert path.parameter_unit == "rad"


@pytest.mark.parametrize("zone", [0.51, 2.0])
def test_zone_beyond_half_a_segment_names_the_corner(zone: float) -> None:
    with pytest.raises(
        InputError,
        match=rf"the zone of corner 1 at \(1, 0\) is {zone:g}, allowed is at most half the shorter .* 0.5, .* make "
        rf"the zone smaller",
    ):
        Sequence(ELBOW, zone)


def test_half_a_segment_is_allowed_and_zones_may_touch() -> None:
    path = Sequence([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.5)
    assert np.all(np.isfinite(path.derivatives(np.linspace(0.0, 3.0, 100))))


def test_second_corner_is_named() -> None:
    with pytest.raises(InputError, match=r"the zone of corner 2 at \(1, 2\) is 0.6"):
        Sequence([*ELBOW, [0.0, 2.0]], [0.4, 0.6])


@pytest.mark.parametrize("zone", [0.0, -0.1, float("nan")])
def test_zone_must_be_positive(zone: float) -> None:
    with pytest.raises(InputError, match="allowed is a finite radius above 0; correct the zone or make the moves stop"):
        Sequence(ELBOW, zone)


def test_number_of_zones_must_be_that_of_corners() -> None:
    with pytest.raises(InputError, match="has 1 corners but 2 zones, allowed is one zone per corner or one number"):
        Sequence(ELBOW, [0.1, 0.1])


def test_equal_points_are_refused() -> None:
    with pytest.raises(
        InputError, match=r"points 1 and 2 of the sequence are both \(1, 0\) so the segment has no length"
    ):
        Sequence([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]], 0.1)


def test_turn_on_the_spot_within_a_sequence_is_refused() -> None:
    with pytest.raises(InputError, match=r"both at \(1, 0, 0\) and only the orientation differs, .* set zone to 0"):
        Sequence([[0.0] * 6, [1.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 1]], 0.1)


def test_one_point_is_refused() -> None:
    with pytest.raises(InputError, match="has 1 points, allowed are 2 or more; add points"):
        Sequence([[0.0, 0.0]], 0.1)
