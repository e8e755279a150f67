"""Whole numbers of experiments: apportionment, few experiments, agreement with all possibilities."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.d_optimal import d_optimal
from flexros.identify.design.rounding import apportion, round_design
from tests.identify.design.test_d_optimal import monomials, random_information


def test_apportionment_is_that_of_the_reference() -> None:
    """With v = ceil((n - l/2) w), then corrected: shares 1/6, 1/3, 1/2 of 10 give 2, 3, 5."""
    assert apportion(np.array([1 / 6, 1 / 3, 1 / 2]), 10).tolist() == [2, 3, 5]
    assert apportion(np.array([1 / 6, 1 / 3, 1 / 2]), 11).tolist() == [2, 4, 5]


@pytest.mark.parametrize("number", [5, 6, 13, 100])
def test_apportionment_gives_every_share_one_and_all_of_them(number: int) -> None:
    counts = apportion(np.array([0.01, 0.04, 0.15, 0.3, 0.5]), number)
    assert counts.sum() == number
    assert counts.min() >= 1


def test_optimal_shares_of_a_parabola_are_rounded_evenly() -> None:
    points = np.linspace(-1, 1, 21)
    counts = round_design(d_optimal(monomials(points, 2)), 9)
    assert counts[[0, 10, 20]].tolist() == [3, 3, 3]


def test_few_experiments_come_close_to_the_best_of_all_sets() -> None:
    information = random_information(18, 4, seed=4, rank=2)
    design = d_optimal(information)
    found = np.linalg.slogdet(np.tensordot(round_design(design, 4), information, axes=1))[1]
    sets = [information[list(chosen)].sum(axis=0) for chosen in combinations_with_replacement(range(18), 4)]
    best = np.linalg.slogdet(np.array(sets))[1].max()
    assert np.exp((found - best) / 4) > 0.97


def test_too_few_experiments_are_refused() -> None:
    design = d_optimal(monomials(np.linspace(-1, 1, 21), 3))
    with pytest.raises(InputError, match="3 experiments cannot determine the 4 parameters in any of the positions"):
        round_design(design, 3)
    with pytest.raises(InputError, match="0 experiments were requested, but at least one is needed"):
        round_design(design, 0)


def test_positions_differ_when_each_may_have_one_experiment() -> None:
    information = random_information(200, 5, seed=6)
    design = d_optimal(information)
    counts = round_design(design, 15, most=1)
    assert counts.sum() == 15
    assert counts.max() == 1
    repeated = round_design(design, 15)
    assert repeated.max() > 1
    values = [np.linalg.slogdet(np.tensordot(n, information, axes=1))[1] for n in (counts, repeated)]
    assert values[0] < values[1]
    with pytest.raises(InputError, match="201 experiments with at most 1 in each of 200 candidate positions"):
        round_design(design, 201, most=1)
