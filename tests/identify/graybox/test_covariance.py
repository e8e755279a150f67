from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.identify.graybox.covariance import NOTHING_KNOWN, parameter_covariance
from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.problem import graybox_problem
from flexros.identify.graybox.weights import CombinedWeights

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.robot.robot import Robot
    from tests.identify.graybox.conftest import Measure

    Responses = tuple[FrequencyResponse, ...]

REPETITIONS = 150


def correlated(exact: Responses) -> tuple[Responses, list[ComplexArray]]:
    """State a covariance that couples outputs and inputs, and return its square roots."""
    stated, roots = [], []
    for response in exact:
        level = 2e-3 * np.median(np.abs(np.einsum("fii->fi", response.response)), axis=0)
        output = np.array([[1.0, 0.5 + 0.3j], [0.5 - 0.3j, 1.0]]) * np.outer(level, level)
        inputs = np.array([[1.0, -0.4j], [0.4j, 0.7]])
        n = len(response.frequency)
        known = replace(response, total_error=np.tile(output, (n, 1, 1)), input_inverse=np.tile(inputs, (n, 1, 1)))
        stated.append(known)
        roots.append(np.linalg.cholesky(known.covariance("total")))
    return tuple(stated), roots


def drawn(stated: Responses, roots: list[ComplexArray], rng: np.random.Generator) -> Responses:
    responses = []
    for response, root in zip(stated, roots, strict=True):
        shape = root.shape[:2]
        circular = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)
        noise = np.einsum("fij,fj->fi", root, circular).reshape(-1, 2, 2).swapaxes(1, 2)
        responses.append(replace(response, response=response.response + noise))
    return tuple(responses)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimator", "weights"), [("LLS", "user"), ("LLSM", "user"), ("NLS", "user"), ("LLS", "optimal")]
)
def test_covariance_is_that_of_repeated_fits(
    estimator: str, weights: str, e12: Robot, e12_names: list[str], exact_e12: Responses
) -> None:
    stated, roots = correlated(exact_e12[:2])
    frame = graybox_problem(e12, stated, e12_names, estimator, weights).reweighted(np.array([1e5, 50.0] * 3))
    rng = np.random.default_rng(11)
    scores = []
    for _ in range(REPETITIONS):
        problem: GrayBoxProblem = replace(frame, responses=drawn(stated, roots, rng))
        result = fit(problem)
        deviation = parameter_covariance(problem, result, correct=False).standard_deviation
        scores.append(np.log(result.values / problem.scale.nominal) / deviation)
    np.testing.assert_allclose(np.std(scores, axis=0), 1.0, atol=0.2)
    covered = np.mean(np.abs(scores) <= 1.96)
    assert 0.92 <= covered <= 0.975


def test_reduced_cost_is_one_when_the_model_explains_all_but_noise(
    e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "NLS", "optimal")
    assert parameter_covariance(problem, fit(problem)).reduced_cost == pytest.approx(1.0, abs=0.12)


def test_covariance_grows_when_there_is_a_model_form_error(
    e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    heavier = e12.with_values({"body_3.mass": 206.0})
    problem = graybox_problem(heavier, noisy_e12, e12_names, "LLS", "optimal")
    result = fit(problem)
    plain, corrected = (parameter_covariance(problem, result, correct) for correct in (False, True))
    assert corrected.reduced_cost > 3.0
    np.testing.assert_allclose(corrected.matrix, plain.matrix * corrected.factor)
    assert "model-form error" in corrected.explanation
    assert "nothing was corrected" in plain.explanation


@pytest.mark.parametrize(
    ("reduced", "said"),
    [
        (0.9, "that of the responses alone"),
        (1.1, "within what scatter explains"),
        (1.4, "because of a model-form error"),
    ],
)
def test_only_a_clear_excess_of_the_cost_is_attributed_to_the_model(
    reduced: float, said: str, e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    result = fit(problem)
    share = parameter_covariance(problem, result).reduced_cost / reduced
    stated = tuple(replace(response, total_error=share * response.total_error) for response in noisy_e12)
    covariance = parameter_covariance(replace(problem, responses=stated), result)
    assert covariance.reduced_cost == pytest.approx(reduced, rel=0.02)
    assert said in covariance.explanation
    assert ("multiplied by this, " in covariance.explanation) == (reduced > 1)


def test_weights_from_few_degrees_of_freedom_inflate(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    few = tuple(replace(response, degrees_of_freedom=20.0) for response in noisy_e12)
    problem = graybox_problem(e12, few, e12_names, "LLS", "optimal")
    covariance = parameter_covariance(problem, fit(problem))
    assert covariance.factor == pytest.approx(20.0 / 18.0 * max(covariance.reduced_cost, 1.0))


@pytest.mark.parametrize(("allowed", "lowest", "highest"), [(1e-6, 0.99, 1.0), (1e-2, 0.05, 0.95), (10.0, 0.0, 0.01)])
def test_combined_weights_inflate_by_what_they_take_from_the_noise(
    allowed: float, lowest: float, highest: float, e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    few = tuple(replace(response, degrees_of_freedom=20.0) for response in noisy_e12)
    combined = CombinedWeights(diagonal=allowed, off_diagonal=allowed)
    problem = graybox_problem(e12, few, e12_names, "LLS", combined)
    result = fit(problem)
    problem = problem.reweighted(result.values)
    plain, corrected = (parameter_covariance(problem, result, correct) for correct in (False, True))
    share = (corrected.factor / max(corrected.reduced_cost, 1.0) - 1.0) / (20.0 / 18.0 - 1.0)
    assert lowest <= share <= highest + 1e-9
    growth = np.diag(corrected.matrix) / np.diag(plain.matrix) / max(corrected.reduced_cost, 1.0)
    assert np.all((growth >= 1.0 - 1e-9) & (growth <= 20.0 / 18.0 + 1e-9))


def test_elements_where_the_model_is_below_the_noise_are_reported(
    e12: Robot, e12_names: list[str], measured: Measure
) -> None:
    loud = measured(e12, np.array([[0.0, 0.3], [0.2, 1.2]]), np.linspace(1.0, 40.0, 60), noise=0.3)
    problem = graybox_problem(e12, loud, e12_names)
    result = fit(problem)
    explanations = [
        parameter_covariance(fitted_problem, result).explanation
        for fitted_problem in (problem, problem.reweighted(result.values))
    ]
    assert re.search(r"; .* [1-9]\d* of \d+ elements are modelled below their noise, so that this is", explanations[0])
    assert "lost in noise" not in explanations[1]


def test_residuals_stand_in_for_a_covariance_that_is_not_known(
    e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    bare = tuple(replace(response, total_error=None) for response in noisy_e12)
    known = graybox_problem(e12, noisy_e12, e12_names, "NLS")
    unknown = replace(graybox_problem(e12, bare, e12_names, "NLS"), weights=known.weights)
    result = fit(unknown)
    covariance = parameter_covariance(unknown, result)
    assert covariance.basis == "residuals"
    np.testing.assert_allclose(
        covariance.standard_deviation, parameter_covariance(known, result).standard_deviation, rtol=0.5
    )


def test_parameter_without_influence_is_unknown(e12: Robot, noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, ["body_1.ry.stiffness", "body_2.length.y"])  # y is the axis of rotation
    covariance = parameter_covariance(problem, fit(problem))
    assert covariance.standard_deviation[0] < 0.01
    assert covariance.standard_deviation[1] == pytest.approx(NOTHING_KNOWN)


def test_intervals_hold_the_value(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    result = fit(problem)
    covariance = parameter_covariance(problem, result)
    intervals = covariance.intervals()
    np.testing.assert_allclose(intervals[:, 0] * intervals[:, 1], result.values**2)
    np.testing.assert_allclose(np.log(intervals[:, 1] / result.values), 1.959964 * covariance.relative)
