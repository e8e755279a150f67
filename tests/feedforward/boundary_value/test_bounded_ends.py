from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.boundary_value.bounded_ends import at_rest_before, bounded_after


def oscillator(damping: float, stiffness: float, h: float = 0.01) -> np.ndarray:
    """Difference equation of q'' + d q' + k q = 0, and an output equation y = 0 with its own unknown force."""
    by_x, by_v, by_a = np.diag([stiffness, 0.0]), np.diag([damping, 0.0]), np.diag([1.0, 0.0])
    constraint = np.array([[0.0, 0.0], [0.0, 1.0]])
    return np.stack([by_a / h**2 - by_v / (2 * h), by_x - 2 * by_a / h**2 + constraint, by_a / h**2 + by_v / (2 * h)])


@pytest.mark.parametrize(
    ("damping", "stiffness", "before", "after"),
    [(1.0, 100.0, 2, 0), (-1.0, 100.0, 0, 2), (0.0, -100.0, 1, 1), (0.0, 100.0, 2, 0)],
    ids=["stable", "unstable", "saddle", "undamped"],
)
def test_stable_solutions_are_excluded_before_and_unstable_ones_after(
    damping: float, stiffness: float, before: int, after: int
) -> None:
    blocks = oscillator(damping, stiffness)
    # the output's unknown of the inner sample is free at either end: one condition more at each
    assert len(at_rest_before(blocks, 1)) == before
    assert len(bounded_after(blocks, 1)) == after


def test_growing_solution_of_a_saddle_is_allowed_before_and_refused_after() -> None:
    h = 0.01
    blocks = oscillator(0.0, -100.0, h)
    factor = np.exp(2 * np.arcsinh(10.0 * h / 2))  # x_{k+1} = factor x_k solves the difference equation
    growing = np.array([1.0, 0.0, factor, 0.0])
    decaying = np.array([factor, 0.0, 1.0, 0.0])
    assert np.abs(at_rest_before(blocks, 1) @ growing).max() < 1e-12
    assert np.abs(at_rest_before(blocks, 1) @ decaying).max() > 1e-2
    assert np.abs(bounded_after(blocks, 1) @ decaying).max() < 1e-12
    assert np.abs(bounded_after(blocks, 1) @ growing).max() > 1e-2
