from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.fit import FitSettings, fit
from flexros.identify.graybox.kernel.structure import packed_target
from flexros.identify.graybox.least_squares import ResponseTarget, least_squares
from flexros.identify.graybox.multistart import random_starts
from flexros.identify.graybox.problem import graybox_problem
from flexros.identify.graybox.weights import UserWeights
from flexros.prediction.damped_least_squares import NormalEquations, StopRule

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.robot.robot import Robot
    from tests.identify.graybox.conftest import Measure

    Responses = tuple[FrequencyResponse, ...]

pytestmark = pytest.mark.slow

# The six estimators of Moberg (2007, Paper A, section 6); LLS1U takes one position.
SIX = {
    "LLSM15U": ("LLSM", "user", 3),
    "LLS15U": ("LLS", "user", 3),
    "LLS15O": ("LLS", "optimal", 3),
    "NLS15U": ("NLS", "user", 3),
    "NLS15O": ("NLS", "optimal", 3),
    "LLS1U": ("LLS", "user", 1),
}


@pytest.mark.parametrize("name", SIX)
def test_truth_of_e12_is_recovered(name: str, e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    estimator, weights, positions = SIX[name]
    problem = graybox_problem(e12, exact_e12[:positions], e12_names, estimator, weights)
    start = problem.scale.nominal * np.array([1.2, 0.6, 0.85, 1.5, 1.15, 0.7])
    result = fit(problem, start)
    assert result.converged
    np.testing.assert_allclose(result.values, problem.scale.nominal, rtol=1e-5)


def test_truth_of_six_axis_is_recovered_from_starts_within_a_decade(
    six_axis: Robot, six_axis_responses: Responses
) -> None:
    problem = graybox_problem(six_axis, six_axis_responses)
    for start in random_starts(problem, 3, seed=0):
        result = fit(problem, start)
        springs = np.array([name.endswith("stiffness") for name in problem.names])
        ratio = result.values / problem.scale.nominal
        assert np.all(np.abs(np.log(ratio[springs])) < 0.02)
        assert np.all(np.abs(np.log(ratio[~springs])) < 0.15)


def test_rests_follow_the_values(e12: Robot, e12_names: list[str], measured: Measure) -> None:
    hanging = e12.with_values({"gravity.z": -9.81})
    truth = hanging.with_values({name: 0.6 * hanging.parameters[name].value for name in e12_names})
    responses = measured(truth, np.array([[0.0, 0.3], [0.5, 1.2]]), np.linspace(1.0, 40.0, 40))
    problem = graybox_problem(hanging, responses, e12_names)
    frozen, followed = fit(problem, settings=FitSettings(relinearisations=0)), fit(problem)
    values = np.array([truth.parameters[name].value for name in e12_names])
    assert np.max(np.abs(frozen.values / values - 1)) > 1e-3
    np.testing.assert_allclose(followed.values, values, rtol=1e-6)
    assert followed.relinearisations >= 2


def test_masses_lengths_and_friction_are_fitted(e12: Robot, measured: Measure) -> None:
    values = {
        "body_1.ry.stiffness": 8e4,
        "body_3.mass": 220.0,
        "motor_2.inertia": 90.0,
        "body_2.length.x": 1.07,
        "motor_1.viscous_friction": 25.0,
        "body_3.center_of_mass.z": -0.03,
    }
    responses = measured(e12.with_values(values), np.array([[0.0, 0.3], [0.2, 1.2]]), np.linspace(1.0, 40.0, 50))
    result = fit(graybox_problem(e12, responses, list(values)))
    np.testing.assert_allclose(result.values, list(values.values()), rtol=1e-5)
    assert result.value("body_3.mass") == pytest.approx(220.0)


def test_friction_that_is_not_there_is_found_to_be_zero(e12: Robot, exact_e12: Responses) -> None:
    names = ["body_1.ry.stiffness", "motor_1.viscous_friction"]
    result = fit(graybox_problem(e12, exact_e12, names), np.array([9e4, 30.0]))
    np.testing.assert_allclose(result.values, [1e5, 0.0], atol=1e-3)


def test_values_stay_within_bounds(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    problem = graybox_problem(e12, exact_e12, e12_names)
    start = problem.scale.nominal * 1.3
    result = fit(problem, start, bounds={"body_1.ry.stiffness": (1.2e5, 2e5)})
    assert result.value("body_1.ry.stiffness") == pytest.approx(1.2e5)
    assert result.at_bound[0]
    assert np.all((result.values >= result.lower * (1 - 1e-12)) & (result.values <= result.upper * (1 + 1e-12)))


@pytest.mark.parametrize("estimator", ["LLS", "LLSM", "NLS"])
def test_gradient_is_that_of_differences(
    estimator: str, e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, estimator)
    squares = least_squares(problem.model, ResponseTarget(problem.measured, problem.weights, estimator))
    scale, step = problem.scale, 1e-5
    x = scale.scaled(scale.nominal * np.array([1.03, 1.2, 0.97, 0.8, 1.01, 1.1]))
    stated = squares.normal_equations(scale.values(x), scale.per_value(scale.values(x))).gradient
    for place, unit in enumerate(np.eye(len(x))):
        ahead, behind = (squares.cost(scale.values(x + sign * step * unit)) for sign in (1, -1))
        assert stated[place] == pytest.approx((ahead - behind) / (2 * step), rel=1e-4, abs=1e-6 * np.abs(stated).max())


def test_fit_that_runs_out_of_steps_says_so(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    problem = graybox_problem(e12, exact_e12, e12_names, weights=UserWeights(off_diagonal=0.0))
    settings = FitSettings(StopRule(iterations=1), relinearisations=0)
    result = fit(problem, problem.scale.nominal * 1.5, settings=settings)
    assert not result.converged
    assert result.message == "the limit of steps was reached"


def test_values_without_a_rest_end_the_fit_at_the_last_step(
    e12: Robot, e12_names: list[str], exact_e12: Responses, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = graybox_problem(e12, exact_e12, e12_names)

    def no_rest(*_: object) -> None:
        raise InputError("robot e12 has no equilibrium")

    monkeypatch.setattr(type(problem), "model_at", no_rest)
    result = fit(problem, problem.scale.nominal * 1.2)
    assert not result.converged
    assert result.message == "the robot could not be linearised again: robot e12 has no equilibrium"
    np.testing.assert_allclose(result.values, problem.scale.nominal, rtol=1e-5)


def test_start_outside_the_bounds_is_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    problem = graybox_problem(e12, exact_e12, e12_names)
    with pytest.raises(InputError, match=r"start of body_1.ry.damping is 5000, but its bounds are 5 and 500; start"):
        fit(problem, problem.scale.nominal * np.array([1, 100, 1, 1, 1, 1]))


def test_start_of_another_length_is_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    with pytest.raises(InputError, match=r"start has the values \[1.0\], allowed is one finite number for each of 6"):
        fit(graybox_problem(e12, exact_e12, e12_names), np.array([1.0]))


def test_value_of_a_parameter_that_was_not_fitted_is_refused(
    e12: Robot, e12_names: list[str], exact_e12: Responses
) -> None:
    result = fit(graybox_problem(e12, exact_e12, e12_names))
    with pytest.raises(InputError, match=r"unknown fitted parameter 'body_3.mass'"):
        result.value("body_3.mass")


def test_values_at_which_the_model_is_singular_are_left_out(
    e12: Robot, e12_names: list[str], exact_e12: Responses, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = graybox_problem(e12, exact_e12, e12_names)
    refused = []

    class Singular:
        def __init__(self, model: FrequencyModel, target: ResponseTarget) -> None:
            self._whole = least_squares(model, target)

        def normal_equations(self, theta: FloatArray, scale: FloatArray) -> NormalEquations:
            self._check(theta)
            return self._whole.normal_equations(theta, scale)

        def cost(self, theta: FloatArray) -> float:
            self._check(theta)
            return self._whole.cost(theta)

        def _check(self, theta: FloatArray) -> None:
            if theta[0] < 0.999e5:
                refused.append(theta)
                raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("flexros.identify.graybox.fit.least_squares", Singular)
    result = fit(problem, problem.scale.nominal * np.array([1.3, 0.5, 1.4, 2.0, 0.7, 0.5]))
    assert refused
    assert result.values[0] >= 0.999e5
    assert np.isfinite(result.cost)


def test_fit_whose_model_fails_at_the_start_says_so(
    e12: Robot, e12_names: list[str], exact_e12: Responses, monkeypatch: pytest.MonkeyPatch
) -> None:
    def singular(*_: object) -> None:
        raise np.linalg.LinAlgError("Singular matrix")

    problem = graybox_problem(e12, exact_e12, e12_names)
    for name in ("cost", "normal_equations"):
        monkeypatch.setattr(type(least_squares(problem.model, problem.target)), name, singular)
    result = fit(problem)
    assert not result.converged
    assert np.isnan(result.cost)
    assert np.isnan(result.start_cost)
    assert result.message == "the model cannot be evaluated at the initial values"


def test_fits_of_one_problem_share_one_target(
    e12: Robot, e12_names: list[str], exact_e12: Responses, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = []

    def counted(*arguments: object, **options: object) -> FloatArray:
        packed.append(1)
        return packed_target(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("flexros.identify.graybox.numpy_least_squares.packed_target", counted)
    problem = graybox_problem(e12, exact_e12, e12_names)
    for start in random_starts(problem, 3, seed=0):
        fit(problem, start, settings=FitSettings(StopRule(iterations=1), relinearisations=1))
    assert len(packed) == 1
