"""Parameters by the parts of a log, and how much they vary beyond chance."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.uncertainty.parts import estimates_of_parts, variation_between_parts

PARTS = 8


def linear_log(sizes: list[float], n: int = 4000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residuals with unit noise and a direction of another size in each part, beside a second one of size 2."""
    rng = np.random.default_rng(5)
    part = np.arange(n) * PARTS // n
    J = rng.normal(size=(n, 2))
    r = rng.normal(size=n) - J @ np.array([0.0, 2.0]) - J[:, 0] * np.array(sizes)[part]
    best = -np.linalg.solve(J.T @ J, J.T @ r)
    return J, r + J @ best, part


def test_sizes_of_parts_are_those_of_each_part() -> None:
    sizes = [1.0, 1.5, 0.5, 1.0, 2.0, 1.0, 0.0, 1.0]
    J, r, part = linear_log(sizes)
    differences, _ = estimates_of_parts(J, r, part, np.zeros(2), np.zeros(2))
    assert float(np.mean(sizes)) + differences[:, 0] == pytest.approx(np.array(sizes), abs=0.25)


def test_a_prior_holds_parameters_where_the_whole_fit_left_them() -> None:
    """With its share of a strong prior, a part moves a parameter hardly."""
    J, r, part = linear_log([0.0, 4.0] * (PARTS // 2))
    differences, deviations = estimates_of_parts(J, r, part, np.array([1e9, 0.0]), np.zeros(2))
    assert np.abs(differences[:, 0]).max() < 1e-4
    assert deviations[:, 0].max() < 1e-3


def test_sizes_that_differ_from_part_to_part_vary_by_as_much_and_equal_ones_hardly() -> None:
    sizes = [1.0, 1.5, 0.5, 1.0, 2.0, 1.0, 0.0, 1.0]
    J, r, part = linear_log(sizes)
    own, other = variation_between_parts(*estimates_of_parts(J, r, part, np.zeros(2), np.zeros(2)))
    assert own == pytest.approx(np.std(sizes, ddof=1), rel=0.15)
    assert other < 0.1 * own


def test_a_part_that_says_nothing_of_a_size_does_not_vary_it() -> None:
    estimates = np.array([[1.0], [1.0], [1.0], [1e6]])
    deviations = np.array([[0.1], [0.1], [0.1], [1e7]])
    assert variation_between_parts(estimates, deviations).tolist() == [0.0]
