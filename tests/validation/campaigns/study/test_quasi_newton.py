from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.validation.campaigns.study.quasi_newton import judged, quasi_newton

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study


@pytest.mark.slow
def test_nearby_minimum_is_found(small_study: Study) -> None:
    problem = small_study.problem
    found = quasi_newton(problem, small_study.best.values * np.array([1.05, 0.9, 0.95, 1.1, 1.02, 1.1]))
    np.testing.assert_allclose(found, small_study.best.values, rtol=0.01)


def test_models_are_judged_at_their_own_rests(small_study: Study) -> None:
    np.testing.assert_allclose(judged(small_study.problem, small_study.best.values), small_study.best.cost)


def test_values_out_of_all_proportion_cost_infinitely_much(small_study: Study) -> None:
    assert judged(small_study.problem, np.full(6, np.inf)) == np.inf
