"""Response matrices from spectra."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.estimate.matrix import estimate, logarithmic_mean

FREQUENCY = np.array([1.0, 2.0])
BLOCK = np.array([0, 0, 1, 1])


def complex_normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


@pytest.mark.parametrize("average", ["joint", "arithmetic", "logarithmic"])
@pytest.mark.parametrize("known", [True, False])
def test_exact_data_give_the_exact_response(average: str, known: bool) -> None:
    rng = np.random.default_rng(1)
    G, R = complex_normal(rng, 2, 3, 2), complex_normal(rng, 2, 2, 4)
    U = complex_normal(rng, 2, 2, 2) @ R
    result = estimate(U, G @ U, R if known else None, BLOCK, average, FREQUENCY)  # type: ignore[arg-type]
    np.testing.assert_allclose(result.response, G, rtol=1e-10)
    np.testing.assert_allclose(U @ result.weights, np.broadcast_to(np.eye(2), (2, 2, 2)), atol=1e-12)


def test_input_inverse_is_that_of_least_squares() -> None:
    U = complex_normal(np.random.default_rng(2), 2, 2, 4)
    result = estimate(U, U, None, BLOCK, "joint", FREQUENCY)
    np.testing.assert_allclose(result.input_inverse, np.linalg.inv(U @ np.conj(np.swapaxes(U, 1, 2))))


def test_known_reference_removes_the_bias_of_noise_in_the_input() -> None:
    """A loop u = r - y, y = 0.5 u + v, with as much noise as reference: least squares is biased towards -1."""
    rng = np.random.default_rng(3)
    m = 40_000
    r, v = complex_normal(rng, 1, 1, m), complex_normal(rng, 1, 1, m)
    u = (r - v) / 1.5
    y, block = 0.5 * u + v, np.zeros(m, dtype=np.int64)
    blind = estimate(u, y, None, block, "joint", FREQUENCY[:1]).response[0, 0, 0]
    known = estimate(u, y, r, block, "joint", FREQUENCY[:1]).response[0, 0, 0]
    assert abs(blind - (0.5 - 0.75)) < 0.03  # 0.5 + E[v conj(u)] / E|u|^2
    assert abs(known - 0.5) < 0.03


def test_logarithmic_mean_is_geometric_and_does_not_jump_in_phase() -> None:
    result = logarithmic_mean(np.array([4 * np.exp(3.1j), np.exp(-3.1j)]).reshape(2, 1, 1, 1))[0, 0, 0]
    assert abs(result - (-2.0)) < 1e-12


def test_too_few_experiments_are_refused() -> None:
    U = np.ones((2, 3, 2), dtype=complex)
    with pytest.raises(InputError, match="2 experiments .* 3 inputs, at least 3 are needed"):
        estimate(U, U, None, BLOCK[:2], "joint", FREQUENCY)


def test_dependent_experiments_are_refused() -> None:
    U = np.ones((2, 2, 4), dtype=complex)
    with pytest.raises(InputError, match="the experiments are not independent at 1 Hz .*use an orthogonal multisine"):
        estimate(U, U, None, BLOCK, "joint", FREQUENCY)


def test_input_without_any_power_is_named() -> None:
    U = np.zeros((2, 1, 4), dtype=complex)
    U[0] = 1
    with pytest.raises(InputError, match="no excitation: input 1 is zero at 2 Hz"):
        estimate(U, U, None, BLOCK, "joint", FREQUENCY)
