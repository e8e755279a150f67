from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.path_geometry import _searched, circle_behind, path_through


def brute_force_distance(vertices, point):
    start, step = vertices[:-1], np.diff(vertices, axis=0)
    along = np.clip(np.sum((point - start) * step, axis=1) / np.sum(step**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(point - start - along[:, None] * step, axis=1).min()


def test_distance_is_to_the_segment_and_not_to_the_nearest_sample():
    path = path_through(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    projection = path.project(np.array([[0.4, 0.0, 0.003]]))
    assert projection.distance[0] == pytest.approx(0.003, abs=1e-15)
    assert projection.position[0] == pytest.approx(0.4, abs=1e-15)


def test_nearest_segment_equals_a_search_over_all_segments():
    rng = np.random.default_rng(3)
    # Very uneven segments: the nearest middle of a segment is often not that of the nearest segment.
    vertices = np.cumsum(rng.normal(size=(120, 3)) * rng.choice([0.01, 1.0], size=(120, 1)), axis=0)
    points = vertices[rng.integers(0, 120, 300)] + rng.normal(scale=0.8, size=(300, 3))
    expected = [brute_force_distance(vertices, point) for point in points]
    np.testing.assert_allclose(path_through(vertices).project(points).distance, expected, rtol=1e-12, atol=1e-12)


def test_rest_adds_no_vertices_and_no_length():
    path = path_through(np.array([[0.0, 0, 0], [0, 0, 0], [1.0, 0, 0], [1.0, 0, 0], [1.0, 2.0, 0]]))
    assert len(path.vertices) == 3
    assert path.length == pytest.approx(3.0)


def test_a_path_that_never_moves_is_a_point():
    projection = path_through(np.zeros((5, 3))).project(np.array([[0.0, 3.0, 4.0]]))
    assert projection.distance[0] == pytest.approx(5.0)


def test_circle_is_recognised_with_centre_and_radius():
    angle = np.linspace(0.0, 2 * np.pi, 400)
    frame, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    centre = np.array([2.0, -1.0, 0.5])
    points = centre + 0.025 * (np.outer(np.cos(angle), frame[0]) + np.outer(np.sin(angle), frame[1]))
    circle = circle_behind(path_through(points))
    assert circle is not None
    assert circle.radius == pytest.approx(0.025, abs=1e-12)
    np.testing.assert_allclose(circle.centre, centre, atol=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_position_on_a_circle_grows_in_the_sense_of_travel(seed):
    angle = np.linspace(0.0, 2 * np.pi, 400)
    frame, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    circle = circle_behind(path_through(np.outer(np.cos(angle), frame[0]) + np.outer(np.sin(angle), frame[1])))
    assert circle is not None
    projection = circle.project((1.1 * frame[1] + 0.2 * frame[2])[None])
    assert projection.position[0] == pytest.approx(np.pi / 2, abs=1e-9)
    assert projection.distance[0] == pytest.approx(np.hypot(0.1, 0.2), abs=1e-12)


@pytest.mark.parametrize("shape", ["arc", "ellipse", "line"])
def test_other_shapes_are_no_circle(shape):
    angle = np.linspace(0.0, np.pi if shape == "arc" else 2 * np.pi, 300)
    height = {"arc": 1.0, "ellipse": 0.99, "line": 0.0}[shape]
    points = np.column_stack([np.cos(angle), np.zeros_like(angle), height * np.sin(angle)])
    assert circle_behind(path_through(points)) is None


def test_chord_error_of_a_coarse_circle_is_its_sagitta():
    radius, steps = 0.025, 90
    angle = np.linspace(0.0, 2 * np.pi, steps + 1)
    points = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    sagitta = radius * (1 - np.cos(np.pi / steps))
    assert path_through(points).chord_error() == pytest.approx(sagitta, rel=0.01)


def slow_and_fast(passes: int) -> np.ndarray:
    """A closed curve whose speed changes by a factor of 1000."""
    angle = 2 * np.pi * (np.arange(3000 * passes + 1) / 3000 % 1)
    turned = angle - 0.999 * np.sin(angle)
    return np.column_stack([np.cos(turned), np.sin(2 * turned), 0.3 * np.cos(3 * turned)])


def test_nearest_segment_of_a_path_with_slow_parts_that_repeats_itself():
    path = path_through(slow_and_fast(3))
    points = slow_and_fast(1)[::37] + np.random.default_rng(1).normal(scale=0.01, size=(82, 3))
    expected = [brute_force_distance(path.vertices, point) for point in points]
    projection = path.project(points)
    np.testing.assert_allclose(projection.distance, expected, atol=3e-8)
    along = [np.interp(projection.position, path.arc_length, path.vertices[:, k]) for k in range(3)]
    np.testing.assert_allclose(projection.nearest, np.column_stack(along), atol=1e-6)
    assert path.project(path.vertices).distance.max() < 3e-8


def test_what_repeats_is_searched_once_and_slow_parts_like_fast_ones():
    once, thrice = (_searched(path_through(slow_and_fast(passes)))[0] for passes in (1, 3))
    assert len(thrice) <= len(once) + 2
    steps = np.linalg.norm(np.diff(once, axis=0), axis=1)
    assert steps.max() < 3 * np.median(steps)
