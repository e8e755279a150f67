from __future__ import annotations

import pickle
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.fit import cost_at, fit
from flexros.identify.graybox.problem import graybox_problem

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot

    Responses = tuple[FrequencyResponse, ...]


def test_unknowns_of_the_robot_file_are_the_default(six_axis: Robot, six_axis_responses: Responses) -> None:
    assert graybox_problem(six_axis, six_axis_responses).names == six_axis.spec.unknown_parameters


def test_responses_of_any_quantity_are_taken(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    positions = [response.as_quantity("position") for response in exact_e12]
    problem = graybox_problem(e12, positions, e12_names)
    assert cost_at(problem, problem.model, problem.scale.nominal) < 1e-18


def test_other_choice_shares_the_measurement(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    other = problem.with_choice("NLS", "optimal")
    direct = graybox_problem(e12, noisy_e12, e12_names, "NLS", "optimal")
    assert other.model is problem.model
    np.testing.assert_array_equal(other.weights, direct.weights)


def test_recomputed_weights_follow_the_model(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "LLS", "optimal")
    again = problem.reweighted(problem.scale.nominal)
    model = problem.model.response(problem.scale.nominal)
    variance = np.stack([response.standard_deviation("total") ** 2 for response in noisy_e12])
    counted = again.weights > 0
    np.testing.assert_allclose(again.weights[counted], (np.abs(model) ** 2 / variance)[counted])


def test_problem_travels_to_other_processes(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "LLS", "optimal").reweighted(np.array([9e4, 60] * 3))
    copy = pickle.loads(pickle.dumps(problem))
    np.testing.assert_array_equal(copy.weights, problem.weights)
    np.testing.assert_array_equal(fit(copy).values, fit(problem).values)


def test_no_response_is_refused(e12: Robot, e12_names: list[str]) -> None:
    with pytest.raises(InputError, match=r"no frequency response was given"):
        graybox_problem(e12, [], e12_names)


def test_response_of_another_robot_is_refused(e12: Robot, e12_names: list[str], six_axis_responses: Responses) -> None:
    with pytest.raises(InputError, match=r"has 6 outputs and 6 inputs, but robot e12 has 2 motors"):
        graybox_problem(e12, six_axis_responses, e12_names)


def test_response_that_is_not_finite_is_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    broken = exact_e12[1].response.copy()
    broken[3, 0, 1] = np.nan
    with pytest.raises(InputError, match=r"frequency response 1 has elements that are zero, infinite or NaN"):
        graybox_problem(e12, [exact_e12[0], replace(exact_e12[1], response=broken)], e12_names)


def test_response_without_motor_position_is_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    spoilt = replace(exact_e12[2], motor_position=np.array([0.1, np.nan]))
    with pytest.raises(InputError, match=r"response 2 .* motor positions .* \(\[0\.1, nan\]\), allowed"):
        graybox_problem(e12, [*exact_e12[:2], spoilt], e12_names)


def test_positions_excited_differently_are_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    other = replace(exact_e12[1], frequency=exact_e12[1].frequency + 0.1)
    with pytest.raises(InputError, match=r"frequency response 1 has other frequencies or another sample time"):
        graybox_problem(e12, [exact_e12[0], other], e12_names)


def test_weights_that_leave_nothing_are_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    lost = [replace(each, total_error=each.total_error * 1e30) for each in exact_e12 if each.total_error is not None]
    with pytest.raises(InputError, match=r"the user weights leave nothing to fit: .*weight 0"):
        graybox_problem(e12, lost, e12_names)


def test_unknown_estimator_is_refused(e12: Robot, e12_names: list[str], exact_e12: Responses) -> None:
    with pytest.raises(InputError, match=r"unknown estimator 'ML'"):
        graybox_problem(e12, exact_e12, e12_names, "ML")
