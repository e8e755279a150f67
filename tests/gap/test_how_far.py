"""The share of a gap that a repair closes, and when none is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.how_far import AheadErrors, closed_fraction
from flexros.random_streams import generator

T = 5e-4
WINDOWS = 800
"""20 s of windows that start every 25 ms."""


def errors(mean: float, seed: int = 1) -> AheadErrors:
    """Errors of two motors with a mean square over the floor."""
    squares = mean * generator(seed).standard_normal((WINDOWS, 2)) ** 2
    return AheadErrors(squares, 50 * np.arange(WINDOWS), np.ones(2))


def test_a_gap_far_above_the_floor_has_a_share_with_an_interval() -> None:
    share = closed_fraction(errors(101.0, 1), errors(11.0, 2), T)
    assert share is not None
    assert share.value == pytest.approx(0.9, abs=0.02)
    assert share.interval[0] < 0.9 < share.interval[1]


@pytest.mark.parametrize("mean", [0.9, 1.0, 1.0 + 1e-9, 1.05])
def test_a_gap_within_its_own_sampling_error_has_no_share(mean: float) -> None:
    assert closed_fraction(errors(mean), errors(1.0, 2), T) is None


def test_a_gap_within_the_error_of_its_floor_has_no_share() -> None:
    squares = np.full((WINDOWS, 2), 1.5)
    before = AheadErrors(squares, 50 * np.arange(WINDOWS), np.ones(2))
    after = replace(before, squares=np.ones((WINDOWS, 2)))
    known = closed_fraction(before, after, T)
    assert known is not None
    assert known.value == pytest.approx(1.0)
    assert closed_fraction(replace(before, floor_error=0.2), after, T) is None


def test_a_single_block_does_not_count_as_sure() -> None:
    short = AheadErrors(np.full((8, 1), 2.0), 50 * np.arange(8), np.ones(1))
    assert closed_fraction(short, replace(short, squares=np.ones((8, 1))), T) is None
