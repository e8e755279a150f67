"""The best further experiment for what is not determined yet."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.design.next_experiment import most_telling_frequency, next_experiment


def test_candidate_that_sees_the_combination_is_found() -> None:
    total = np.diag([1e6, 1.0])
    candidates = np.array([np.diag([1e8, 0.0]), np.diag([0.0, 3.0]), np.diag([1.0, 1.0])])
    best = next_experiment(total, candidates, np.array([0.0, 1.0]))
    assert best.candidate == 1
    assert best.before == pytest.approx(1)
    assert best.after == pytest.approx(0.5)


def test_combination_counts_and_not_single_parameters() -> None:
    """The difference of two stiffnesses is open: a candidate that sees only their sum does not help."""
    both, apart = np.array([1.0, 1.0]), np.array([1.0, -1.0])
    total = 100 * np.outer(both, both) + 0.1 * np.outer(apart, apart)
    candidates = np.array([1e4 * np.outer(both, both), np.outer(apart, apart)])
    assert next_experiment(total, candidates, apart / np.sqrt(2)).candidate == 1


def test_frequency_that_tells_most_is_found() -> None:
    by_frequency = np.array([np.diag([1e3, 0.0]), np.diag([1.0, 0.2]), np.diag([0.0, 0.5])])
    assert most_telling_frequency(by_frequency, by_frequency.sum(axis=0), np.array([0.0, 1.0])) == 2
