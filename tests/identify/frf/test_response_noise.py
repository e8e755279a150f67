from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.identify.frf.response_noise import response_noise
from flexros.robot import load_robot
from tests.identify.graybox.conftest import E12_FREQUENCY, E12_POSES, measure

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse


@pytest.fixture(scope="module")
def noisy_e12() -> tuple[FrequencyResponse, ...]:
    return measure(load_robot("e12"), E12_POSES, E12_FREQUENCY, noise=3e-3)


def test_total_covariance_is_preferred(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    total = noisy_e12[0].total_error
    assert total is not None
    noise = response_noise(replace(noisy_e12[0], noise_error=0.1 * total))
    assert noise is not None
    assert noise.kind == "total"
    np.testing.assert_allclose(noise.error, total)


def test_noise_stands_in_where_there_is_one_block(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    noise = response_noise(replace(noisy_e12[0], noise_error=noisy_e12[0].total_error, total_error=None))
    assert noise is not None
    assert noise.kind == "noise"


def test_record_without_repetition_has_none(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    assert response_noise(replace(noisy_e12[0], total_error=None)) is None


def test_covariance_is_that_of_the_estimate(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    response = replace(noisy_e12[1], noise_error=0.1 * noisy_e12[1].error())
    noise = response_noise(response)
    assert noise is not None
    np.testing.assert_array_equal(noise.input_inverse, response.input_inverse)
    np.testing.assert_array_equal(noise.covariance(), response.covariance("total"))
    np.testing.assert_allclose(noise.variance, response.standard_deviation("total") ** 2)
    assert noise.degrees_of_freedom == response.degrees_of_freedom


def test_covariance_of_few_degrees_of_freedom_is_not_pooled_once_more(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    """The estimate of the response did that, and its degrees of freedom count it."""
    scatter = np.random.default_rng(0).gamma(4.0, 0.25, len(noisy_e12[0].frequency))
    response = replace(noisy_e12[0], total_error=noisy_e12[0].error() * scatter[:, None, None], degrees_of_freedom=4.0)
    noise = response_noise(response)
    assert noise is not None
    assert noise.degrees_of_freedom == 4.0
    np.testing.assert_array_equal(noise.error, response.error())
