"""The search: many starts with user weights, the last fit with those that are wanted."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.report.result import IdentificationResult
from flexros.identify.search import SearchSettings, search
from tests.identify.report.conftest import NAMES, ROBOT, TRUTH, make_result


@pytest.fixture(scope="module")
def clear() -> IdentificationResult:
    return make_result(10.0)


def test_first_start_is_the_robot_and_the_last_fit_uses_the_model(clear: IdentificationResult) -> None:
    found = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=3, seed=2))
    assert found.searched[0].start == pytest.approx([ROBOT.parameters[name].value for name in NAMES])
    assert found.fit.weights == "combined"
    assert np.any(found.problem.weights != found.problem.with_choice("LLS", "combined").weights)
    assert found.fit.value("body_1.ry.stiffness") == pytest.approx(TRUTH["body_1.ry.stiffness"], rel=0.02)


def test_optimal_weights_come_last_and_use_the_responses_better(clear: IdentificationResult) -> None:
    found = search(ROBOT, clear.problem.responses, NAMES, SearchSettings(weights="optimal", starts=2))
    assert {each.weights for each in found.searched} == {"user"}
    assert found.fit.weights == found.problem.setting.kind == "optimal"
    for name in ("body_2.ry.stiffness", "body_3.ry.stiffness"):
        assert found.fit.value(name) == pytest.approx(TRUTH[name], rel=0.002)


def test_progress_counts_fits(clear: IdentificationResult) -> None:
    done: list[int] = []
    search(ROBOT, clear.problem.responses, NAMES, SearchSettings(starts=3), progress=done.append)
    assert done == [1, 2, 3]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (SearchSettings(starts=0), "0 starts were asked for, but at least one is needed"),
        (SearchSettings(weights="equal"), "unknown kind of weights 'equal'"),
        (SearchSettings(estimator="LLT"), "unknown estimator 'LLT'"),
    ],
)
def test_wrong_choices_are_refused_before_the_search(
    clear: IdentificationResult, settings: SearchSettings, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        search(ROBOT, clear.problem.responses, NAMES, settings)
