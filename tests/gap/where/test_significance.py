"""Significance and concentration."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.where.significance import concentration, p_values


def test_p_value_counts_the_largest_of_all_places() -> None:
    random = np.random.default_rng(1)
    null = random.standard_normal((99, 50))
    found = np.zeros(50)
    found[7] = 8.0
    p = p_values(found, null)
    assert p[7] == 0.01
    assert p[8] > 0.5


def test_p_values_hold_their_size_for_any_distribution() -> None:
    random = np.random.default_rng(3)
    smallest = []
    for _ in range(600):
        every = random.exponential(size=(41, 30)) ** 2
        smallest.append(p_values(every[0], every[1:]).min())
    assert np.mean(np.array(smallest) <= 0.1) == pytest.approx(0.1, abs=0.06)


def test_concentration_is_zero_for_an_even_spread() -> None:
    assert concentration(np.array([0.2, 0.1]), np.array([0.2, 0.3])) == pytest.approx([0.0, 0.0])
    assert concentration(np.array([1.0]), np.array([0.25]))[0] == pytest.approx(np.log(4))
