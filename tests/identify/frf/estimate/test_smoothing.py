"""Windows over time and frequency."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.estimate.smoothing import data_window, smoothed_estimate, triangular


def complex_normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


def test_triangular_window_of_length_five() -> None:
    np.testing.assert_allclose(triangular(5) * 9, [1, 2, 3, 2, 1])
    np.testing.assert_allclose(triangular(1), [1])


def test_even_length_is_refused() -> None:
    with pytest.raises(InputError, match="a triangular window of length 4 has no middle; give an odd length"):
        triangular(4)


def test_data_windows_have_mean_one_and_their_shape() -> None:
    for kind in ("boxcar", "bartlett", "hann"):
        assert abs(data_window(kind, 101).mean() - 1) < 1e-12  # type: ignore[arg-type]
    bartlett = data_window("bartlett", 101)
    np.testing.assert_allclose(np.diff(bartlett[:51]), bartlett[1])
    np.testing.assert_allclose(bartlett, bartlett[::-1], atol=1e-12)


def test_length_one_is_the_ratio_of_the_spectra() -> None:
    rng = np.random.default_rng(0)
    U, Y = complex_normal(rng, 9, 1, 1), complex_normal(rng, 9, 1, 1)
    result = smoothed_estimate(U, Y, None, triangular(1))
    np.testing.assert_allclose(result.response, Y / U)
    assert result.error is None


@pytest.mark.parametrize("known", [True, False])
def test_errors_are_as_large_as_claimed_where_the_response_is_constant(known: bool) -> None:
    rng = np.random.default_rng(1)
    G, sigma = np.array([[1.0, 0.5j], [-0.2, 2.0]]), 0.3
    errors, claimed = [], []
    for _ in range(60):
        U = complex_normal(rng, 40, 2, 2)
        Y = G @ U + sigma * complex_normal(rng, 40, 2, 2)
        result = smoothed_estimate(U, Y, U if known else None, triangular(7))
        assert result.error is not None
        inner = slice(4, 36)
        errors.append(np.sum(abs(result.response - G)[inner] ** 2, axis=(1, 2)))
        variances = np.einsum("fii->f", result.error).real * np.einsum("fii->f", result.input_inverse).real
        claimed.append(variances[inner])
    assert abs(np.sum(errors) / np.sum(claimed) - 1) < 0.08
