from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.response_noise import response_noise

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse


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


def test_many_degrees_of_freedom_need_no_neighbours(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    noise = response_noise(noisy_e12[1])
    assert noise is not None
    np.testing.assert_allclose(noise.covariance(), noisy_e12[1].covariance("total"))
    np.testing.assert_allclose(noise.variance, noisy_e12[1].standard_deviation("total") ** 2)


def test_few_degrees_of_freedom_are_averaged_over_neighbours(noisy_e12: tuple[FrequencyResponse, ...]) -> None:
    rng, given = np.random.default_rng(0), noisy_e12[0]
    colour = (2 * np.pi * given.frequency) ** 4
    drawn = rng.gamma(4.0, 0.25, (len(colour), 2)) * colour[:, None]
    error = np.einsum("fi,ij->fij", drawn, np.eye(2)) + 0j
    noise = response_noise(replace(given, total_error=error, degrees_of_freedom=4.0))
    assert noise is not None
    assert noise.degrees_of_freedom == 4.0 * 5
    steadied = np.einsum("fii->fi", noise.error).real / colour[:, None]
    np.testing.assert_allclose(steadied.mean(), 1.0, atol=0.1)
    assert steadied.std() < 0.6 * (drawn / colour[:, None]).std()
