"""Signs of bias: absent where the robot is linear, reported for each effect that the model does not contain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.graybox.bias import bias_signs
from flexros.identify.graybox.scatter import ScatterLimits
from flexros.identify.report.record import identification_record
from flexros.identify.report.verdict import covariance_text, verdict
from flexros.identify.result import IdentificationResult


def with_levels(result: IdentificationResult, **changed: np.ndarray) -> IdentificationResult:
    """Replace levels of the distortion of every position."""
    responses = []
    for response in result.problem.responses:
        assert response.distortion is not None
        responses.append(replace(response, distortion=replace(response.distortion, **changed)))
    return replace(result, problem=replace(result.problem, responses=tuple(responses)))


def test_linear_robot_shows_no_sign(clear: IdentificationResult) -> None:
    assert clear.bias_signs == ()
    assert "intervals" not in verdict(clear)
    assert identification_record(clear)["bias_signs"] == []


def test_odd_distortions_are_a_sign(distorted: IdentificationResult) -> None:
    assert distorted.bias_signs == ("odd detection lines of motor_2 carry 50 times their noise",)
    assert "the intervals do not cover this bias" in verdict(distorted)
    assert identification_record(distorted)["bias_signs"] == list(distorted.bias_signs)


def test_misfit_is_a_sign_once_it_is_beyond_scatter(clear: IdentificationResult) -> None:
    for reduced, count in ((1.25, 0), (1.35, 1)):
        covariance = replace(clear.covariance, reduced_cost=reduced)
        assert len(bias_signs(clear.problem, covariance, clear.residuals)) == count
    residuals = replace(clear.residuals, chi_square=3.9)
    (sign,) = bias_signs(clear.problem, clear.covariance, residuals)
    assert sign.startswith("the squared misfit is 3.9 times the variance")


def test_misfit_that_chance_explains_is_no_sign(clear: IdentificationResult) -> None:
    covariance, residuals = replace(clear.covariance, reduced_cost=1.7), replace(clear.residuals, chi_square=2.5)
    limits = ScatterLimits(cost=2.2, chi_square=3.0)
    assert len(bias_signs(clear.problem, covariance, residuals)) == 1
    assert bias_signs(clear.problem, covariance, residuals, limits) == ()


def test_fit_on_a_bound_is_no_evidence_about_the_robot(clear: IdentificationResult) -> None:
    covariance = replace(
        clear.covariance, reduced_cost=50.0, explanation="by 50: by this, because of a model-form error."
    )
    missed = replace(clear, covariance=covariance)
    assert "The model has a form error" in verdict(missed)
    assert "because of a model-form error" in covariance_text(missed)
    bound = replace(missed, fit=replace(clear.fit, at_bound=np.arange(6) == 2))
    assert bound.bias_signs == ()
    assert "The fit ended on a bound of the search, so the misfit is no evidence about the robot." in verdict(bound)
    assert "model misses" not in covariance_text(bound)
    broken_off = replace(missed, fit=replace(clear.fit, converged=False))
    assert "The fit did not converge, so the misfit is no evidence about the robot." in verdict(broken_off)


def test_cost_is_no_sign_where_errors_are_not_known(clear: IdentificationResult) -> None:
    covariance = replace(clear.covariance, basis="residuals", reduced_cost=5.0)
    assert bias_signs(clear.problem, covariance, replace(clear.residuals, chi_square=float("nan"))) == ()


@pytest.mark.parametrize(("share", "signs"), [(0.004, 0), (0.03, 1)])
def test_even_distortions_count_only_where_they_are_large(
    clear: IdentificationResult, share: float, signs: int
) -> None:
    levels = clear.problem.responses[0].distortion
    assert levels is not None
    even = share * levels.output[5:10] * [0.1, 1.0]
    found_signs = with_levels(clear, even_frequency=levels.frequency[5:10], even=even, even_noise=0.1 * even).bias_signs
    assert len(found_signs) == signs
    assert all(sign.startswith("even detection lines of motor_2 carry") for sign in found_signs)


def test_without_detection_lines_blocks_are_used(clear: IdentificationResult) -> None:
    levels = clear.problem.responses[0].distortion
    assert levels is not None
    none = np.zeros((0, 2))
    silent = with_levels(clear, odd_frequency=none[:, 0], odd=none, odd_noise=none, total=levels.noise)
    assert silent.bias_signs == ()
    loud = with_levels(silent, total=levels.noise * [1.0, 4.0])
    assert loud.bias_signs == ("with the phases of the excitation responses of motor_2 vary 4.0 times the noise",)
