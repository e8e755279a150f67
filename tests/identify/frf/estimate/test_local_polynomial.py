"""The local polynomial method on records with transients."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from flexros.errors import InputError
from flexros.identify.frf.estimate.local_polynomial import half_width, local_polynomial

N = 1024


def complex_normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


def spectra(samples: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Shape (F, n, m) of samples (m, N, n)."""
    return np.moveaxis(2 / N * np.fft.rfft(samples, axis=1)[:, lines], 0, 2)


def random_record(rng: np.random.Generator, m: int, n_u: int) -> tuple[np.ndarray, np.ndarray]:
    """Input noise and the output of a filter that was running before the record began: leakage."""
    u = rng.standard_normal((m, 3 * N, n_u))
    y = np.stack(
        [
            lfilter([1.0, 0.4], [1.0, -1.5, 0.7], u[..., 0], axis=1) + lfilter([0.5], [1.0, -0.8], u[..., -1], axis=1),
            lfilter([0.3], [1.0, 0.5], u[..., -1], axis=1),
        ],
        axis=2,
    )
    return u[:, -N:], y[:, -N:]


def truth(lines: np.ndarray, n_u: int) -> np.ndarray:
    d = np.exp(-2j * np.pi * lines / N)
    first, second, third = (1 + 0.4 * d) / (1 - 1.5 * d + 0.7 * d**2), 0.5 / (1 - 0.8 * d), 0.3 / (1 + 0.5 * d)
    columns = [[first + second, third]] if n_u == 1 else [[first, 0 * third], [second, third]]
    return np.moveaxis(np.array(columns), (0, 1, 2), (2, 1, 0))


@pytest.mark.parametrize(("m", "n_u"), [(1, 1), (1, 2), (3, 2)])
def test_leakage_is_modelled(m: int, n_u: int) -> None:
    rng = np.random.default_rng(2)
    lines = np.arange(20, 400)
    u, y = random_record(rng, m, n_u)
    U, Y = spectra(u, lines), spectra(y, lines)
    at = np.arange(20, 360, 5)
    result = local_polynomial(U, Y, None, at).response
    error = np.median(abs(result - truth(lines[at], n_u)))
    assert error < 2e-3
    if m == n_u:
        plain = (Y @ np.linalg.inv(U))[at]
        assert np.median(abs(plain - truth(lines[at], n_u))) > 10 * error


@pytest.mark.parametrize("known", [True, False])
def test_errors_are_as_large_as_claimed(known: bool) -> None:
    rng = np.random.default_rng(3)
    lines, errors, claimed = np.arange(20, 300), [], []
    at = np.arange(15, 265, 10)
    for _ in range(40):
        u, y = random_record(rng, 1, 2)
        U = spectra(u, lines)
        Y = spectra(y, lines) + 0.02 * complex_normal(rng, len(lines), 2, 1)
        result = local_polynomial(U, Y, U if known else None, at, spare=6)
        assert result.error is not None
        errors.append(np.sum(abs(result.response - truth(lines[at], 2)) ** 2, axis=(1, 2)))
        claimed.append(np.einsum("fii->f", result.error).real * np.einsum("fii->f", result.input_inverse).real)
    assert abs(np.sum(errors) / np.sum(claimed) - 1) < 0.15


def test_known_reference_removes_the_bias_of_the_loop() -> None:
    """u = r - y, y = 0.5 u + v with strong v: without the reference the estimate tends to -1."""
    rng = np.random.default_rng(4)
    R, V = complex_normal(rng, 4000, 1, 1), complex_normal(rng, 4000, 1, 1)
    U = (R - V) / 1.5
    Y = 0.5 * U + V
    at = np.arange(60, 3900, 120)
    blind = local_polynomial(U, Y, None, at, spare=100).response
    known = local_polynomial(U, Y, R, at, spare=100).response
    assert abs(np.mean(blind) - (-0.25)) < 0.08
    assert abs(np.mean(known) - 0.5) < 0.08


def test_width_leaves_the_degrees_of_freedom_wanted() -> None:
    half = half_width(2, 3, 2, 8)
    assert (2 * half + 1) * 3 - 3 * (2 + 3) >= 8
    assert (2 * half - 1) * 3 - 3 * (2 + 3) < 8


def test_too_short_a_record_is_refused() -> None:
    U = np.ones((5, 1, 1), dtype=complex)
    with pytest.raises(InputError, match="too short a record: 5 lines in the band, the local polynomials need 11"):
        local_polynomial(U, U, None, np.array([2]))


def test_input_without_excitation_is_refused() -> None:
    U = np.zeros((30, 1, 1), dtype=complex)
    with pytest.raises(InputError, match="no excitation: the inputs cannot be separated from the transients"):
        local_polynomial(U, U, None, np.array([15]))
