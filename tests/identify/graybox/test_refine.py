from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.problem import graybox_problem
from flexros.identify.graybox.refine import refine

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot

    Responses = tuple[FrequencyResponse, ...]


def test_refined_fit_is_more_accurate(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    rough = fit(problem, problem.scale.nominal * 1.2)
    refined = refine(problem, rough)
    before = parameter_covariance(problem, rough).standard_deviation
    after = parameter_covariance(refined.problem, refined.fit).standard_deviation
    assert np.all(after < 0.7 * before)
    assert refined.fit.weights == "combined"
    np.testing.assert_allclose(np.log(refined.fit.values / problem.scale.nominal) / after, 0.0, atol=4.0)


def test_weights_belong_to_the_fitted_model(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    refined = refine(problem, fit(problem))
    assert 1 < refined.rounds <= 4
    assert refined.settled
    again = refined.problem.reweighted(refined.fit.values).weights
    np.testing.assert_allclose(again, refined.problem.weights, rtol=0.05)


def test_optimal_weights_need_a_covariance(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    bare = tuple(replace(response, total_error=None) for response in noisy_e12)
    problem = graybox_problem(e12, bare, e12_names)
    with pytest.raises(InputError, match=r"optimal weights need the covariance"):
        refine(problem, fit(problem))


def test_weights_that_did_not_settle_are_reported(
    e12: Robot, e12_names: list[str], noisy_e12: Responses, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.identify.graybox.refine.MOST_ROUNDS", 1)
    problem = graybox_problem(e12, noisy_e12, e12_names)
    refined = refine(problem, fit(problem, problem.scale.nominal * 1.2), weights="optimal")
    assert refined.rounds == 1
    assert not refined.settled
