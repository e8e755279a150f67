"""Whether the size of an effect is the same throughout a log."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.constancy import constancy, estimates_of_parts
from flexros.gap.settings import RankingSettings

RNG = np.random.default_rng(5)
PARTS, FEWEST = RankingSettings().parts, RankingSettings().fewest_parts


def linear_log(sizes: list[float], n: int = 4000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residuals with unit noise and a direction of another size in each part, beside a second one of size 2."""
    part = np.arange(n) * PARTS // n
    J = RNG.normal(size=(n, 2))
    r = RNG.normal(size=n) - J @ np.array([0.0, 2.0]) - J[:, 0] * np.array(sizes)[part]
    best = -np.linalg.solve(J.T @ J, J.T @ r)
    return J, r + J @ best, part


def sizes_of_parts(sizes: list[float]) -> np.ndarray:
    """Sizes of the first direction by each part alone, around the fit of the whole."""
    J, r, part = linear_log(sizes)
    nothing = np.zeros(2)
    differences, _ = estimates_of_parts(J, r, part, nothing, nothing)
    return float(np.mean(sizes)) + differences[:, 0]


def test_sizes_of_parts_are_those_of_each_part() -> None:
    """Each part finds its own size, to the noise."""
    sizes = [1.0, 1.5, 0.5, 1.0, 2.0, 1.0, 0.0, 1.0]
    assert sizes_of_parts(sizes) == pytest.approx(np.array(sizes), abs=0.25)


def test_a_true_effect_is_constant_and_an_imitation_is_not() -> None:
    """An effect of one size stands out of its scatter; one that follows something else does not."""
    assert constancy(sizes_of_parts([1.0] * PARTS), FEWEST) > 20
    assert constancy(sizes_of_parts([3.0, -2.0, 0.5, 4.0, -1.0, 2.5, 0.0, 1.0]), FEWEST) < 3


def test_a_part_with_an_impact_does_not_hide_a_constant_effect() -> None:
    """The size of a single part may be anything."""
    assert constancy(sizes_of_parts([1.0] * (PARTS - 1) + [40.0]), FEWEST) > 20


def test_a_prior_holds_parameters_where_the_whole_fit_left_them() -> None:
    """With its share of a strong prior, a part moves a parameter hardly."""
    J, r, part = linear_log([0.0, 4.0] * (PARTS // 2))
    differences, deviations = estimates_of_parts(J, r, part, np.array([1e9, 0.0]), np.zeros(2))
    assert np.abs(differences[:, 0]).max() < 1e-4
    assert deviations[:, 0].max() < 1e-3


def test_few_parts_say_nothing() -> None:
    """Three estimates that agree may do so by chance."""
    assert constancy(np.ones(FEWEST - 1), FEWEST) == 0.0
    assert constancy(np.array([1.0, 1.0, 1.0, np.nan]), FEWEST) == 0.0
