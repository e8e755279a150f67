"""Order and fill-in compared with numerical elimination."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.graybox.kernel.elimination import eliminate


def random_pattern(n: int, seed: int) -> list[tuple[int, int]]:
    rng = np.random.default_rng(seed)
    return [(i, j) for i in range(n) for j in range(i + 1) if i == j or rng.random() < 0.3]


@pytest.mark.parametrize("seed", range(4))
def test_structure_is_that_of_the_numbers(seed: int) -> None:
    n, places = 9, (2, 7)
    entries = random_pattern(n, seed)
    elimination = eliminate(n, entries, places)
    rng = np.random.default_rng(seed)
    A = np.zeros((n + 2, n + 2))
    for i, j in entries:
        A[i, j] = A[j, i] = rng.uniform(1, 2) + 20 * (i == j)
    for number, place in enumerate(places):
        A[n + number, place] = A[place, n + number] = 1.0
    order = [*elimination.order, n, n + 1]
    A = A[np.ix_(order, order)]
    for pivot in range(n):
        assert elimination.below[pivot] == tuple(int(row) for row in pivot + 1 + np.flatnonzero(A[pivot + 1 :, pivot]))
        A[pivot + 1 :, pivot + 1 :] -= np.outer(A[pivot + 1 :, pivot], A[pivot, pivot + 1 :]) / A[pivot, pivot]


def test_leaves_go_first_and_right_hand_sides_last() -> None:
    star = [(0, leaf) for leaf in range(1, 6)]
    elimination = eliminate(6, star, (5,))
    assert set(elimination.order[:4]) == {1, 2, 3, 4}  # no fill-in, no right-hand side
    assert all(len(below) == 1 for below in elimination.below[:4])


def test_products_of_a_full_matrix() -> None:
    n, m = 5, 2
    full = [(i, j) for i in range(n) for j in range(i)]
    elimination = eliminate(n, full, (3, 4))
    pairs = sum(d * (d + 1) // 2 for d in range(n))
    assert elimination.order == (0, 1, 2, 3, 4)
    assert elimination.products == pairs + sum(range(n)) * m + 1  # both right-hand sides wait; one entry below pivot 3
