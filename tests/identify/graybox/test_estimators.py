from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.estimators import ESTIMATORS, estimator_named

G = np.array([2.0 + 1.0j, -0.3 + 0.4j])


def test_nls_compares_the_responses() -> None:
    np.testing.assert_allclose(ESTIMATORS["NLS"].error(G + 0.1j, G), 0.1j)


def test_lls_compares_magnitude_and_angle() -> None:
    error = ESTIMATORS["LLS"].error(2.0 * G * np.exp(0.3j), G)
    np.testing.assert_allclose(error, np.log(2.0) + 0.3j)


def test_lls_takes_the_short_way_round() -> None:
    error = ESTIMATORS["LLS"].error(np.exp(np.array([3.0j])), np.exp(np.array([-3.0j])))
    np.testing.assert_allclose(error, 6.0j - 2j * np.pi)


def test_llsm_compares_magnitudes_alone() -> None:
    np.testing.assert_allclose(ESTIMATORS["LLSM"].error(2.0 * G * np.exp(0.3j), G), np.log(2.0))


@pytest.mark.parametrize("name", sorted(ESTIMATORS))
def test_slope_is_the_derivative_of_the_error(name: str) -> None:
    estimator, step = ESTIMATORS[name], 1e-6
    direction = np.array([0.3 - 0.2j, 0.5 + 1.0j])
    difference = estimator.error(1.1 * G, G + step * direction) - estimator.error(1.1 * G, G - step * direction)
    np.testing.assert_allclose(estimator.slope(G, direction[:, None])[:, 0], -difference / (2 * step), rtol=1e-8)


@pytest.mark.parametrize("name", sorted(ESTIMATORS))
def test_error_covariance_is_that_of_drawn_errors(name: str) -> None:
    estimator, rng = ESTIMATORS[name], np.random.default_rng(3)
    root = 0.01 * np.array([[1.0, 0.0], [0.6 + 0.3j, 0.4]])
    noise = (rng.standard_normal((40_000, 2)) + 1j * rng.standard_normal((40_000, 2))) / np.sqrt(2)
    errors = estimator.error(G + noise @ root.T, G)
    drawn = errors.T @ errors.conj() / len(errors)
    stated = estimator.noise_share * estimator.error_covariance(root @ root.conj().T, G)
    np.testing.assert_allclose(drawn, stated, atol=0.03 * np.abs(stated).max())


@pytest.mark.parametrize("name", ["LLS", "LLSM"])
def test_optimal_weight_is_that_of_equation_8(name: str) -> None:
    weights = ESTIMATORS[name].optimal_weight(np.array([0.01, 0.0]), G)
    np.testing.assert_allclose(weights, [5.0 / 0.01, 0.0])


def test_optimal_weight_of_nls_is_that_of_equation_6() -> None:
    np.testing.assert_allclose(ESTIMATORS["NLS"].optimal_weight(np.array([0.01, np.nan]), G), [100.0, 0.0])


def test_unknown_estimator_is_named_with_those_there_are() -> None:
    with pytest.raises(
        InputError, match=r"unknown estimator 'LLSS' in key estimator: did you mean 'LLSM?'\?.*LLSM, NLS"
    ):
        estimator_named("LLSS", "key estimator")
