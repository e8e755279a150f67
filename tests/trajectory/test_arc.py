from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexros.arrays import FloatArray
from flexros.errors import InputError
from flexros.trajectory.arc import Arc, circle


def test_circle_of_paper_b_has_its_centre_inward(start: FloatArray) -> None:
    path = circle(start, 0.025)
    np.testing.assert_allclose(path.centre, start - [0.025, 0.0])
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    expected = path.centre + 0.025 * np.column_stack((np.cos(angle), np.sin(angle)))
    np.testing.assert_allclose(path.derivatives(angle, 0)[0], expected, atol=1e-15)
    assert path.extent == 2.0 * np.pi


@pytest.mark.parametrize(("plane", "quarter"), [("xy", [-1, 1, 0]), ("yz", [0, -1, 1]), ("xz", [-1, 0, 1])])
def test_planes_in_space_turn_from_the_first_to_the_second_coordinate(plane: str, quarter: list[float]) -> None:
    np.testing.assert_allclose(circle(np.zeros(3), 1.0, turns=0.25, plane=plane).end, quarter, atol=1e-15)


def test_negative_turns_go_the_other_way() -> None:
    np.testing.assert_allclose(circle(np.zeros(2), 1.0, turns=-0.25).end, [-1.0, -1.0], atol=1e-15)


def test_arc_about_a_centre_is_right_handed_about_its_normal() -> None:
    arc = Arc.about(np.zeros(3), np.array([2.0, 0.0, 0.0]), np.pi / 2, np.array([0.0, 0.0, 5.0]))
    np.testing.assert_allclose(arc.start, [2.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(arc.end, [0.0, 2.0, 0.0], atol=1e-15)


def test_arc_in_a_plane_needs_no_normal() -> None:
    np.testing.assert_allclose(Arc.about(np.zeros(2), np.array([2.0, 0.0]), -np.pi / 2).end, [0.0, -2.0], atol=1e-15)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10_000), st.floats(0.3, 5.9), st.floats(0.1, 0.9))
def test_arc_through_three_points_meets_them_in_order(seed: int, angle: float, share: float) -> None:
    rng = np.random.default_rng(seed)
    u, v = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    centre, radius = rng.normal(size=3), rng.uniform(0.1, 2.0)
    first, via, last = (centre + radius * (np.cos(a) * u + np.sin(a) * v) for a in (0.0, share * angle, angle))
    arc = Arc.through(first, via, last)
    assert arc.extent == pytest.approx(angle, rel=1e-6)
    np.testing.assert_allclose(arc.start, first, atol=1e-8)
    np.testing.assert_allclose(arc.point_at(share * angle), via, atol=1e-6)
    np.testing.assert_allclose(arc.end, last, atol=1e-8)


@pytest.mark.parametrize(
    "points",
    [
        ([0.0, 0.0], [1.0, 1.0], [2.0, 2.0]),
        ([0.0, 0.0], [0.0, 0.0], [2.0, 2.0]),
        ([0.0, 0.0], [1.0, 2.0], [0.0, 0.0]),
        ([0.0, 0.0, 0.0], [1e-3, 1e-3, 1e-3], [2.0, 2.0, 2.0]),
    ],
)
def test_collinear_points_are_refused(points: tuple[list[float], ...]) -> None:
    with pytest.raises(InputError, match="collinear, allowed are points of a circle"):
        Arc.through(*(np.array(p) for p in points))


@pytest.mark.parametrize("radius", [0.0, -0.1, float("nan"), float("inf")])
def test_impossible_radius_is_refused(radius: float) -> None:
    with pytest.raises(InputError, match="the radius is .* m, allowed is a finite number above 0; correct the radius"):
        circle(np.zeros(2), radius)


def test_zero_turns_are_refused() -> None:
    with pytest.raises(
        InputError, match="the angle of the arc is 0 rad, allowed is a finite angle other than 0; correct"
    ):
        circle(np.zeros(2), 1.0, turns=0.0)


def test_start_angle_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match="the start angle is nan rad"):
        Arc(np.zeros(2), 1.0, np.array([1.0, 0.0]), np.array([0.0, 1.0]), float("nan"), 1.0)


def test_unknown_plane_is_refused() -> None:
    with pytest.raises(InputError, match="the plane of the circle is 'zy', allowed are xy, yz, xz; choose one of them"):
        circle(np.zeros(3), 1.0, plane="zy")


@pytest.mark.parametrize("size", [1, 4])
def test_circle_outside_plane_and_space_is_refused(size: int) -> None:
    with pytest.raises(InputError, match=f"the circle has {size} coordinates, allowed are 2 or 3"):
        circle(np.zeros(size), 1.0)
    with pytest.raises(InputError, match=f"the arc has {size} coordinates, allowed are 2 or 3"):
        Arc.through(np.zeros(size), np.ones(size), np.ones(size))
    with pytest.raises(InputError, match=f"the arc has {size} coordinates, allowed are 2 or 3"):
        Arc.about(np.zeros(size), np.ones(size), 1.0)


def test_arc_from_its_centre_is_refused() -> None:
    with pytest.raises(InputError, match=r"starts at its centre \(1, 1\) so its radius is 0 m.*move the centre"):
        Arc.about(np.ones(2), np.ones(2), 1.0)


def test_arc_in_space_needs_a_normal_at_right_angles() -> None:
    with pytest.raises(InputError, match="has no normal, allowed is a vector of 3 numbers; give the axis"):
        Arc.about(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0)
    for normal in ([1.0, 0.0, 1.0], [0.0, 0.0, 0.0]):
        with pytest.raises(InputError, match="allowed is a vector at right angles to the radius direction"):
            Arc.about(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0, np.array(normal))
