"""The record of a frequency response: covariance, quantities, objects of other libraries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.files.labelled import dataset_of
from flexros.identify.frf.frequency_response import FrequencyResponse


def response(n_y: int = 2, n_u: int = 2, n_lines: int = 3) -> FrequencyResponse:
    rng = np.random.default_rng(4)

    def hermitian(n: int) -> np.ndarray:
        root = rng.standard_normal((n_lines, n, n)) + 1j * rng.standard_normal((n_lines, n, n))
        return np.asarray(root @ np.conj(np.swapaxes(root, 1, 2)))

    return FrequencyResponse(
        frequency=np.array([1.0, 2.0, 4.0])[:n_lines],
        response=rng.standard_normal((n_lines, n_y, n_u)) + 1j * rng.standard_normal((n_lines, n_y, n_u)),
        noise_error=hermitian(n_y),
        total_error=hermitian(n_y),
        input_inverse=hermitian(n_u),
        degrees_of_freedom=4.0,
        input_names=tuple(f"motor_{i + 1}" for i in range(n_u)),
        output_names=tuple(f"motor_{i + 1}" for i in range(n_y)),
        input_units=("Nm",) * n_u,
        coordinate_units=("rad",) * n_y,
        gears=np.zeros(n_y),
        motor_position=np.zeros(n_y),
        sample_time=1e-3,
        n_periods=2,
        n_blocks=2,
    )


def test_covariance_is_that_of_an_error_times_weights() -> None:
    """vec(E W) with E of covariance C per column, drawn many times, has the covariance conj(W^H W) kron C."""
    rng = np.random.default_rng(0)
    n_y, n_u, m, draws = 2, 3, 5, 40_000
    W = rng.standard_normal((m, n_u)) + 1j * rng.standard_normal((m, n_u))
    root = rng.standard_normal((n_y, n_y)) + 1j * rng.standard_normal((n_y, n_y))
    E = root @ (rng.standard_normal((draws, n_y, m)) + 1j * rng.standard_normal((draws, n_y, m))) / np.sqrt(2)
    vec = np.swapaxes(E @ W, 1, 2).reshape(draws, -1)
    sampled = vec.T @ vec.conj() / draws
    claimed = replace(
        response(n_y, n_u, 1), total_error=(root @ root.conj().T)[None], input_inverse=(W.conj().T @ W)[None]
    ).covariance()[0]
    assert np.linalg.norm(sampled - claimed) < 0.03 * np.linalg.norm(claimed)


def test_standard_deviation_is_the_root_of_the_diagonal() -> None:
    original = response(2, 3)
    diagonal = np.einsum("fii->fi", original.covariance()).real
    np.testing.assert_allclose(original.standard_deviation() ** 2, np.swapaxes(diagonal.reshape(3, 3, 2), 1, 2))


def test_quantities_differ_by_powers_of_jw_and_come_back() -> None:
    original = response()
    position = original.as_quantity("position")
    s = 2j * np.pi * original.frequency[:, None, None]
    np.testing.assert_allclose(position.response * s**2, original.response, rtol=1e-14)
    np.testing.assert_allclose(position.standard_deviation() * abs(s) ** 2, original.standard_deviation(), rtol=1e-14)
    assert position.output_units == ("rad", "rad")
    assert original.output_units == ("rad/s²", "rad/s²")
    np.testing.assert_allclose(position.as_quantity("acceleration").response, original.response, rtol=1e-14)


@pytest.mark.slow
def test_frd_has_the_response_at_its_frequencies() -> None:
    original = response(2, 3)
    frd = original.frd()
    np.testing.assert_allclose(frd.omega, 2 * np.pi * original.frequency)
    np.testing.assert_array_equal(frd.frdata[:, :, 1], original.response[1])
    assert frd.dt == 1e-3
    assert frd.input_labels == ["motor_1", "motor_2", "motor_3"]


def test_dataset_is_labelled() -> None:
    data = dataset_of(response(2, 3))
    original = response(2, 3)
    assert complex(data["response"].sel(frequency=2.0, output="motor_2", input="motor_3")) == original.response[1, 1, 2]
    assert data["response"].attrs["output_units"] == "rad/s²;rad/s²"
    assert data["frequency"].attrs["units"] == "Hz"
    assert data.attrs["quantity"] == "acceleration"


def test_unknown_covariance_says_what_to_record() -> None:
    with pytest.raises(InputError, match="the total covariance .* is not known; record two blocks or more"):
        replace(response(), total_error=None).covariance()
    with pytest.raises(InputError, match="the noise covariance .* is not known; record two periods or more"):
        replace(response(), noise_error=None).covariance("noise")


def test_wrong_shape_is_named() -> None:
    with pytest.raises(InputError, match=r"total_error has shape \(3, 3, 3\), allowed is \(3, 2, 2\)"):
        replace(response(), total_error=np.zeros((3, 3, 3), dtype=complex))


def test_unknown_quantity_offers_the_nearest() -> None:
    with pytest.raises(InputError, match="unknown quantity .* 'velocty': did you mean 'velocity'"):
        response().as_quantity("velocty")  # type: ignore[arg-type]


def test_line_zero_cannot_be_integrated() -> None:
    with pytest.raises(InputError, match="the acceleration at 0 Hz cannot be integrated to velocity; leave the line"):
        replace(response(), frequency=np.array([0.0, 1.0, 2.0])).as_quantity("velocity")
