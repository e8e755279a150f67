"""Whether the size of an effect is the same throughout a log."""

from __future__ import annotations

import numpy as np

from flexros.gap.fit.uncertainty.constancy import constancy
from flexros.gap.fit.uncertainty.parts import estimates_of_parts
from flexros.gap.settings import RankingSettings
from tests.gap.fit.uncertainty.test_parts import linear_log

PARTS, FEWEST = RankingSettings().parts, RankingSettings().fewest_parts


def sizes_of_parts(sizes: list[float]) -> np.ndarray:
    """Sizes of the first direction by each part alone, around the fit of the whole."""
    J, r, part = linear_log(sizes)
    nothing = np.zeros(2)
    differences, _ = estimates_of_parts(J, r, part, nothing, nothing)
    return float(np.mean(sizes)) + differences[:, 0]


def test_a_true_effect_is_constant_and_an_imitation_is_not() -> None:
    """An effect of one size stands out of its scatter; one that follows something else does not."""
    assert constancy(sizes_of_parts([1.0] * PARTS), FEWEST) > 20
    assert constancy(sizes_of_parts([3.0, -2.0, 0.5, 4.0, -1.0, 2.5, 0.0, 1.0]), FEWEST) < 3


def test_a_part_with_an_impact_does_not_hide_a_constant_effect() -> None:
    """The size of a single part may be anything."""
    assert constancy(sizes_of_parts([1.0] * (PARTS - 1) + [40.0]), FEWEST) > 20


def test_few_parts_say_nothing() -> None:
    """Three estimates that agree may do so by chance."""
    assert constancy(np.ones(FEWEST - 1), FEWEST) == 0.0
    assert constancy(np.array([1.0, 1.0, 1.0, np.nan]), FEWEST) == 0.0
