"""Search: fits from several initial values with user weights, then the requested weights."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.fit import GrayBoxFit
from flexros.identify.graybox.multistart import multistart
from flexros.identify.graybox.search import SearchSettings, search
from flexros.identify.result import IdentificationResult
from tests.identify.conftest import NAMES, ROBOT, TRUTH, make_result


@pytest.fixture(scope="module")
def clear() -> IdentificationResult:
    return make_result(10.0)


def test_first_start_is_the_robot_and_the_last_fit_uses_the_model(clear: IdentificationResult) -> None:
    result = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=3, seed=2))
    assert result.searched[0].start == pytest.approx([ROBOT.parameters[name].value for name in NAMES])
    assert result.fit.weights == "combined"
    assert np.any(result.problem.weights != result.problem.with_choice("LLS", "combined").weights)
    assert result.fit.value("body_1.ry.stiffness") == pytest.approx(TRUTH["body_1.ry.stiffness"], rel=0.02)


def test_optimal_weights_come_last_and_use_the_responses_better(clear: IdentificationResult) -> None:
    result = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(weights="optimal", starts=2))
    assert {each.weights for each in result.searched} == {"user"}
    assert result.fit.weights == result.problem.setting.kind == "optimal"
    for name in ("body_2.ry.stiffness", "body_3.ry.stiffness"):
        assert result.fit.value(name) == pytest.approx(TRUTH[name], rel=0.002)


def test_progress_counts_fits(clear: IdentificationResult) -> None:
    done: list[int] = []
    search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=3), progress=done.append)
    assert done == [1, 2, 3]


def test_search_keeps_within_bounds(clear: IdentificationResult) -> None:
    bounds = {"body_1.ry.stiffness": (1.3e5, 1.5e5), "body_3.ry.damping": (1.0, 1e3)}
    result = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=4, bounds=bounds))
    for each in (*result.searched, result.fit):
        assert 1.3e5 * (1 - 1e-9) <= each.start[0] <= 1.5e5 * (1 + 1e-9)
        assert each.value("body_1.ry.stiffness") == pytest.approx(1.3e5)  # the truth is 1.2e5


def test_starts_that_fail_are_reported(clear: IdentificationResult, monkeypatch: pytest.MonkeyPatch) -> None:
    def second_fails(*arguments: Any, **options: Any) -> tuple[GrayBoxFit, ...]:
        first, second, *others = multistart(*arguments, **options)
        return (first, replace(second, cost=np.nan, converged=False), *others)

    monkeypatch.setattr("flexros.identify.graybox.search.multistart", second_fails)
    result = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=3))
    assert result.failed == 1
    assert result.warnings == ("1 of 3 starts failed, because the model cannot be evaluated there.",)


def test_weights_that_did_not_settle_are_reported(clear: IdentificationResult, monkeypatch: pytest.MonkeyPatch) -> None:
    settled = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=1))
    monkeypatch.setattr("flexros.identify.graybox.refine.SETTLED", 0.0)
    result = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=1))
    assert settled.settled
    assert settled.warnings == ()
    assert not result.settled
    assert "weights of the last fit did not settle" in result.warnings[0]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (SearchSettings(starts=0), "0 starts were requested, but at least one is needed"),
        (SearchSettings(weights="equal"), "unknown kind of weights 'equal'"),
        (SearchSettings(estimator="LLT"), "unknown estimator 'LLT'"),
    ],
)
def test_wrong_choices_are_refused_before_the_search(
    clear: IdentificationResult, settings: SearchSettings, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        search(ROBOT, clear.problem.responses, NAMES, settings)
