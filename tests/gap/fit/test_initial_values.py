"""Initial values: all combinations of those of the candidates, or as many as allowed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.candidates.candidate import FreeParameter
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.initial_values import MOST, initial_values, starts_of
from tests.gap.diagnosis_logs import candidates_of, predictor_of

pytestmark = pytest.mark.slow


def test_starts_are_all_combinations() -> None:
    pair = [candidates_of()[name] for name in ("coulomb_friction@motor_1", "stiffness_error@body_2.rz")]
    counts = [len(one.free[0].starts) for one in pair]
    tolerance = Tolerance(("body_1.rz.stiffness",), (0.02,))
    free = initial_values(predictor_of(*pair, tolerance=tolerance))
    assert free.shape == (3, counts[0] * counts[1])
    assert len(np.unique(free, axis=1).T) == counts[0] * counts[1]
    assert not free[2].any()


def test_more_starts_than_allowed_are_thinned_over_their_whole_range() -> None:
    sizes = tuple(float(size) for size in np.geomspace(1e-4, 1.0, 2 * MOST))
    candidate = candidates_of()["coulomb_friction@motor_1"]
    many = replace(candidate, free=(FreeParameter("level", 1e-4, 1.0, signed=False, starts=sizes),))
    starts = initial_values(predictor_of(many))[0]
    assert len(starts) == MOST
    np.testing.assert_allclose(starts[[0, -1]], np.log([1e-4, 1.0]), atol=1e-12)
    assert np.diff(starts).max() < 3.01 * np.log(sizes[1] / sizes[0])  # of two or three combinations one is kept


def test_of_a_law_that_others_shape_one_size_may_be_enough() -> None:
    """Linear theory scales a size, but not a speed: eight of 25 combinations left out the speed of a hump."""
    stribeck = candidates_of()["stribeck_friction@motor_1"]
    sizes, speeds, _ = starts_of((stribeck,), of_one_size=True)
    assert len(set(sizes)) == 1
    assert set(speeds) == set(starts_of((stribeck,))[1])
    coulomb, spring = (candidates_of()[name] for name in ("coulomb_friction@motor_1", "nonlinear_stiffness@body_2.rz"))
    assert np.array_equal(starts_of((coulomb,), of_one_size=True), starts_of((coulomb,)))
    relative = starts_of((spring,), of_one_size=True)[0]
    assert set(np.sign(relative)) == {-1.0, 1.0}
    assert len(set(relative)) == 2
