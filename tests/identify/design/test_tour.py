"""Order of the positions: complete, short, from the initial position of the robot."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from flexros.identify.design.tour import short_tour


def length(start: np.ndarray, positions: np.ndarray, order: tuple[int, ...]) -> float:
    points = np.vstack([start, positions[list(order)]])
    return float(np.abs(np.diff(points, axis=0)).max(axis=1).sum())


def test_tour_is_nearly_the_shortest() -> None:
    generator = np.random.default_rng(1)
    for _ in range(5):
        start, positions = generator.normal(size=3), generator.normal(size=(6, 3))
        order = short_tour(start, positions)
        assert sorted(order) == list(range(6))
        best = min(length(start, positions, each) for each in permutations(range(6)))
        assert length(start, positions, tuple(order)) <= 1.15 * best


def test_positions_on_a_line_are_visited_in_order() -> None:
    positions = np.array([[3.0], [1.0], [4.0], [2.0]])
    assert short_tour(np.array([0.0]), positions).tolist() == [1, 3, 0, 2]


def test_single_position() -> None:
    assert short_tour(np.zeros(2), np.ones((1, 2))).tolist() == [0]
