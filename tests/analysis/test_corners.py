from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from flexros.analysis.corners import corner_deviations, find_corners
from flexros.analysis.cycles import Cycle


def square_corner(step=1e-3, offset=0.0):
    """Along x to the corner (0.1, 0, 0), then along z; samples may miss the corner by `offset`."""
    s = np.arange(offset, 0.2, step)
    x, z = np.minimum(s, 0.1), np.maximum(s - 0.1, 0.0)
    return np.column_stack([x, np.zeros_like(s), z])


def cycle(attained, commanded):
    return Cycle(np.arange(len(commanded)) * 1e-3, commanded, attained)


@pytest.mark.parametrize("offset", [0.0, 0.3e-3, 0.5e-3])
def test_corner_is_found_where_the_legs_meet_even_between_samples(offset):
    corners = find_corners(square_corner(offset=offset))
    assert len(corners) == 1
    np.testing.assert_allclose(corners[0].point, [0.1, 0.0, 0.0], atol=1e-9)
    assert corners[0].angle == pytest.approx(np.pi / 2)


def test_rounding_of_a_known_radius_leaves_the_corner_by_its_distance():
    radius, commanded = 0.01, square_corner(step=1e-4)
    attained = commanded.copy()
    bend = np.linalg.norm(commanded - [0.1, 0, 0], axis=1) < radius
    angle = np.linspace(0.0, np.pi / 2, np.count_nonzero(bend))
    attained[bend] = np.column_stack(
        [0.1 - radius + radius * np.sin(angle), np.zeros_like(angle), radius - radius * np.cos(angle)]
    )
    (result,) = corner_deviations([cycle(attained, commanded)])
    assert result.rounding == pytest.approx(radius * (np.sqrt(2) - 1), rel=1e-4)
    assert result.overshoot == pytest.approx(0.0, abs=1e-12)


def test_overshoot_is_the_distance_outside_the_second_leg():
    commanded = square_corner(step=1e-4)
    attained = commanded.copy()
    after = commanded[:, 2] > 0
    attained[after, 0] += 8e-4 * np.exp(-commanded[after, 2] / 0.01) * np.sin(commanded[after, 2] / 0.004)
    (result,) = corner_deviations([cycle(attained, commanded)])
    assert result.overshoot == pytest.approx(np.max(attained[:, 0]) - 0.1, rel=1e-9)


def test_worst_cycle_counts():
    commanded = square_corner(step=1e-4)
    shifts = [np.array([-d, 0.0, d]) for d in (1e-4, 3e-4)]
    (result,) = corner_deviations([cycle(commanded + shift, commanded) for shift in shifts])
    assert result.rounding == pytest.approx(np.sqrt(2) * 3e-4, rel=1e-9)


@pytest.mark.parametrize("samples", [36, 400])
def test_a_circle_has_no_corner(samples):
    angle = np.linspace(0, 2 * np.pi, samples + 1)
    assert find_corners(np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])) == ()


def test_corners_between_curves_are_left_out():
    angle = np.linspace(0, np.pi, 200)
    arc = np.column_stack([1 - np.cos(angle), 0 * angle, np.sin(angle)])
    assert find_corners(np.concatenate([arc, arc[1:] + np.array([2.0, 0.0, 0.0])])) == ()


def test_only_the_straight_part_of_a_leg_counts():
    angle = np.linspace(0, np.pi / 2, 500)
    bow = np.column_stack([0.1 + 0.05 * (1 - np.cos(angle)), 0 * angle, 0.1 + 0.05 * np.sin(angle)])
    commanded = np.concatenate([square_corner(step=1e-4), bow])
    (result,) = corner_deviations([cycle(commanded, commanded)])
    assert result.corner.after_length == pytest.approx(0.1, abs=2e-4)
    assert result.overshoot == pytest.approx(0.0, abs=1e-6)


def test_turning_back_is_no_corner():
    x = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0, 50)[1:]])
    assert find_corners(np.column_stack([x, 0 * x, 0 * x])) == ()


def test_all_corners_of_a_polygon_are_found_in_order():
    corners = np.array([[0, 0], [1, 0], [1.5, 1], [0.5, 1.5], [-0.5, 0.5]], dtype=float)
    legs = [np.linspace(a, b, 40, endpoint=False) for a, b in pairwise(corners)]
    flat = np.concatenate([*legs, corners[-1:]])
    found_corners = find_corners(np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]]))
    np.testing.assert_allclose([c.point[[0, 2]] for c in found_corners], corners[1:-1], atol=1e-9)
