from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.estimators import ESTIMATORS
from flexros.identify.graybox.weights import CombinedWeights, OptimalWeights, UserWeights, weights_named

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.estimators import AbstractEstimator

    Responses = tuple[FrequencyResponse, ...]

LLS, LLSM, NLS = ESTIMATORS["LLS"], ESTIMATORS["LLSM"], ESTIMATORS["NLS"]


def test_user_weights_are_constant_and_lower_off_the_diagonal(exact_e12: Responses) -> None:
    weights = UserWeights(diagonal=2.0, off_diagonal=0.3).array(exact_e12, LLS)
    np.testing.assert_array_equal(weights, np.broadcast_to([[2.0, 0.3], [0.3, 2.0]], weights.shape))


def test_single_elements_can_be_weighted(exact_e12: Responses) -> None:
    weights = UserWeights(elements={"motor_2.motor_1": 0.7}).array(exact_e12, LLS)
    assert np.all(weights[:, :, 1, 0] == 0.7)
    assert np.all(weights[:, :, 0, 1] == 0.2)


def test_lines_outside_the_band_have_no_weight(exact_e12: Responses) -> None:
    weights = UserWeights(lowest=5.0, highest=20.0).array(exact_e12, LLS)
    inside = (exact_e12[0].frequency >= 5.0) & (exact_e12[0].frequency <= 20.0)
    np.testing.assert_array_equal(weights[:, :, 0, 0] > 0, np.broadcast_to(inside, weights.shape[:2]))


@pytest.mark.parametrize("kind", ["user", "optimal", "combined"])
def test_logarithms_of_lines_below_the_noise_have_no_weight(exact_e12: Responses, kind: str) -> None:
    error = exact_e12[0].total_error
    assert error is not None
    loud = error.copy()
    loud[7] = 1e6 * np.eye(2)
    weights = weights_named(kind).array([replace(exact_e12[0], total_error=loud)], LLS)
    assert np.all(weights[0, 7] == 0.0)
    assert np.all(weights[0, 8] > 0.0)


def test_nls_drops_elements_that_are_below_the_noise_as_a_whole(exact_e12: Responses) -> None:
    response = exact_e12[0].response.copy()
    response[:, 0, 1] *= 1e-12
    weights = UserWeights().array([replace(exact_e12[0], response=response)], NLS)
    assert np.all(weights[0, :, 0, 1] == 0.0)
    assert np.all(weights[0, :, 1, 0] > 0.0)


def test_user_weights_of_nls_are_relative_to_the_element(exact_e12: Responses) -> None:
    weights = UserWeights().array(exact_e12, NLS)
    power = np.mean([np.abs(response.response[:, 0, 0]) ** 2 for response in exact_e12])
    np.testing.assert_allclose(weights[:, :, 0, 0], 1.0 / power)


@pytest.mark.parametrize("estimator", [LLS, LLSM])
def test_optimal_weights_are_those_of_equation_8(noisy_e12: Responses, estimator: AbstractEstimator) -> None:
    weights = OptimalWeights().array(noisy_e12[:1], estimator)[0]
    relative = noisy_e12[0].standard_deviation("total") / np.abs(noisy_e12[0].response)
    clear = relative**2 <= 0.1
    np.testing.assert_allclose(weights[clear], relative[clear] ** -2)


def test_optimal_weights_of_nls_are_those_of_equation_6(noisy_e12: Responses) -> None:
    weights = OptimalWeights().array(noisy_e12[:1], NLS)[0]
    np.testing.assert_allclose(weights, noisy_e12[0].standard_deviation("total") ** -2)


def test_combined_weights_lie_below_both(noisy_e12: Responses) -> None:
    setting = CombinedWeights(diagonal=0.1, off_diagonal=0.2)
    combined, optimal = setting.array(noisy_e12, LLS), OptimalWeights().array(noisy_e12, LLS)
    clear = combined > 0
    allowed = np.broadcast_to([[0.01, 0.04], [0.04, 0.01]], combined.shape)
    np.testing.assert_allclose(1.0 / combined[clear], (allowed + 1.0 / np.where(clear, optimal, 1.0))[clear])


def test_optimal_weights_without_covariance_are_refused(exact_e12: Responses) -> None:
    bare = replace(exact_e12[0], total_error=None)
    with pytest.raises(InputError, match=r"optimal weights need the covariance .* record two blocks or two periods"):
        OptimalWeights().array([bare], LLS)


def test_unknown_element_is_named(exact_e12: Responses) -> None:
    with pytest.raises(InputError, match=r"unknown element of the response 'motor_3.motor_1' in key elements"):
        UserWeights(elements={"motor_3.motor_1": 1.0}).array(exact_e12, LLS)


def test_negative_element_is_refused(exact_e12: Responses) -> None:
    with pytest.raises(InputError, match=r"motor_1.motor_1 is -1, allowed is 0 or more"):
        UserWeights(elements={"motor_1.motor_1": -1.0}).array(exact_e12, LLS)


def test_band_without_lines_is_refused(exact_e12: Responses) -> None:
    with pytest.raises(InputError, match=r"lowest is 50 Hz, highest is not set, but the responses reach from 1 to 40"):
        UserWeights(lowest=50.0).array(exact_e12, LLS)


def test_unknown_kind_is_named() -> None:
    with pytest.raises(InputError, match=r"unknown kind of weights 'best'.*allowed are combined, optimal, user"):
        weights_named("best")
