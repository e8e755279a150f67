from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.identify.graybox.fit import cost_at, fit
from flexros.identify.graybox.multistart import random_starts
from flexros.validation.campaigns.study.choices import SIX
from flexros.validation.campaigns.study.jobs import fitted_rows, study_jobs
from flexros.validation.campaigns.study.settings import StudySettings

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study

pytestmark = pytest.mark.slow


def test_all_six_estimators_fit_from_the_same_starts(small_study: Study) -> None:
    settings = StudySettings(starts=12, peers=10, seed=3)
    jobs = study_jobs(small_study.problem, settings)
    assert len(jobs) == 6 * 2
    starts = random_starts(small_study.problem, 12, 3)
    for kind in SIX:
        groups = [arguments[2] for name, arguments in jobs.items() if name.startswith(f"{kind.name}_")]
        np.testing.assert_array_equal(np.vstack(groups), starts)
        assert [arguments[3] for arguments in jobs.values()] == [True, False] * 6
        assert small_study.runs[kind.name].values.shape == (4, 6)


def test_rows_are_those_of_single_fits(small_study: Study) -> None:
    problem = small_study.problem
    start = random_starts(problem, 1, 3)[0]
    (row,) = fitted_rows(problem, "LLSM15U", 0, [start.tolist()], False)["rows"]
    found = fit(problem.with_choice("LLSM", "user"), start)
    np.testing.assert_array_equal(row["values"], found.values)
    assert row["iterations"] == found.iterations
    assert row["peer_cost"] is None


def test_truth_of_a_linear_robot_is_among_the_models(small_study: Study) -> None:
    ratio = np.log(small_study.best.values / small_study.problem.scale.nominal)
    assert np.all(np.abs(ratio) < 5 * small_study.corrected + 1e-3)
    assert np.all(np.abs(ratio[::2]) < 0.02)


def test_models_are_judged_by_the_cost_of_the_reference(small_study: Study) -> None:
    problem = small_study.problem
    for name in ("LLS15U", "LLS1U"):
        run = small_study.runs[name]
        costs = [cost_at(problem, problem.model_at(values), values) for values in run.values]
        np.testing.assert_allclose(run.user_cost, costs)


def test_theory_agrees_with_the_spread_of_redrawn_responses(small_study: Study) -> None:
    ratio = small_study.spread / small_study.theory
    assert np.all((ratio > 0.7) & (ratio < 1.35))  # 30 draws: 1 +- 0.13


def test_theory_is_that_of_weights_from_the_model(small_study: Study) -> None:
    np.testing.assert_array_less(small_study.theory, small_study.corrected * (1 + 1e-12))
    assert "lost in noise" not in small_study.explanation
    np.testing.assert_allclose(small_study.refined.values, small_study.best.values, rtol=0.1)


def test_one_position_is_chosen_for_the_single_estimator(small_study: Study) -> None:
    assert small_study.single in range(3)
