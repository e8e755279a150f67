from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.multistart import random_starts
from flexros.identify.study.choices import SIX

if TYPE_CHECKING:
    from flexros.identify.study.campaign import Study


def test_all_six_estimators_fit_from_the_same_starts(small_study: Study) -> None:
    starts = random_starts(small_study.problem, 6, 3)
    assert list(small_study.runs) == [kind.name for kind in SIX]
    for kind in SIX:
        fits = small_study.runs[kind.name].fits
        np.testing.assert_array_equal([fit.start for fit in fits], starts)
        assert {(fit.estimator, fit.weights) for fit in fits} == {(kind.estimator, kind.weights)}


def test_truth_of_a_linear_robot_is_among_the_models(small_study: Study) -> None:
    ratio = np.log(small_study.best.values / small_study.problem.scale.nominal)
    assert np.all(np.abs(ratio) < 5 * small_study.theory + 1e-3)
    assert np.all(np.abs(ratio[::2]) < 0.02)


def test_models_are_judged_by_the_cost_of_the_reference(small_study: Study) -> None:
    run = small_study.runs["LLS15U"]
    np.testing.assert_allclose(run.user_cost, [fit.cost for fit in run.fits], rtol=1e-4)
    optimal = small_study.runs["LLS15O"]
    np.testing.assert_allclose(optimal.optimal_cost, [fit.cost for fit in optimal.fits], rtol=1e-4)


def test_theory_agrees_with_the_spread_of_redrawn_responses(small_study: Study) -> None:
    ratio = small_study.spread / small_study.theory
    assert np.all((ratio > 0.5) & (ratio < 1.7))


def test_one_position_is_chosen_for_the_single_estimator(small_study: Study) -> None:
    assert small_study.single in range(3)
