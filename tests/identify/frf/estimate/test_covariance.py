"""Calibration of the error covariances by Monte Carlo with known noise."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.frf.estimate.covariance import error_covariance
from flexros.identify.frf.estimate.matrix import estimate
from flexros.identify.frf.estimate.period_spectra import PeriodSpectra

N_LINES, N_PERIODS, N_BLOCKS, DRAWS = 12, 2, 3, 150
NOISE = np.array([[1.0, 0.6, 0.0], [0.6, 2.0, 0.3], [0.0, 0.3, 0.5]])
"""Covariance of the output noise of one period."""


def complex_normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


def closed_loop_spectra(rng: np.random.Generator, G: np.ndarray, distortion: float) -> PeriodSpectra:
    """Spectra of U = C (R - Y), Y = G U + V at every line: V goes through the controller C into U."""
    n, m = 3, 3 * N_BLOCKS
    controller = 8.0 * np.eye(n) + 2.0j * np.ones((n, n))
    R = 60.0 * np.exp(2j * np.pi * rng.random((N_LINES, n, N_BLOCKS)))
    T = np.exp(2j * np.pi * np.outer(np.arange(n), np.arange(n)) / n)
    R = np.einsum("fib,ie->fibe", R, T).reshape(N_LINES, n, m)
    root = np.linalg.cholesky(NOISE)
    V = np.einsum("ij,pfjm->pfim", root, complex_normal(rng, N_PERIODS, N_LINES, n, m))
    V = V + distortion * (root @ complex_normal(rng, N_LINES, n, m))
    U = np.linalg.solve(np.eye(n) + controller @ G, controller @ (R - V))
    Y = G @ U + V
    order = (3, 0, 1, 2)
    return PeriodSpectra(
        lines=np.arange(1, N_LINES + 1),
        period=100,
        sample_time=1e-2,
        input=np.transpose(U, order),
        output=np.transpose(Y, order),
        reference=np.transpose(np.broadcast_to(R, U.shape), order),
        block=np.arange(m) // n,
    )


@pytest.mark.slow
@pytest.mark.parametrize(("average", "distortion"), [("joint", 0.0), ("joint", 1.5), ("arithmetic", 0.0)])
def test_covariance_of_the_estimate_is_right_in_closed_loop(average: str, distortion: float) -> None:
    """Mean of error error^H equals mean of the claimed covariance, as a matrix, within the accuracy of the draws."""
    rng = np.random.default_rng(7)
    G = np.array([[1.0, 0.2j, 0.1], [0.3, 0.8, -0.1j], [0.0, 0.1, 0.5 + 0.5j]]) * np.ones((N_LINES, 1, 1))
    errors, totals, noises, squares = [], [], [], []
    for _ in range(DRAWS):
        spectra = closed_loop_spectra(rng, G, distortion)
        U, Y, R = (
            np.transpose(part.mean(axis=1), (1, 2, 0)) for part in (spectra.input, spectra.output, spectra.reference)
        )
        result = estimate(U, Y, R, spectra.block, average, spectra.frequency)  # type: ignore[arg-type]
        error = error_covariance(spectra, result, 0, 3)
        assert error.noise is not None
        assert error.total is not None
        vec = np.swapaxes(result.response - G, 1, 2).reshape(N_LINES, 9)
        errors.append(np.einsum("fi,fj->ij", vec, vec.conj()) / N_LINES)
        weight = np.conj(result.input_inverse)
        claimed = (
            np.einsum("fab,fij->faibj", weight, part).reshape(N_LINES, 9, 9) for part in (error.total, error.noise)
        )
        total, noise = claimed
        totals.append(total.mean(axis=0))
        noises.append(noise.mean(axis=0))
        squares.append(np.mean(abs(vec) ** 2) / np.mean(np.einsum("fii->fi", total).real))
    sampled, total, noise = (np.mean(part, axis=0) for part in (errors, totals, noises))
    assert abs(np.mean(squares) - 1) < 0.04
    assert np.linalg.norm(sampled - total) < 0.06 * np.linalg.norm(total)
    expected = 1.0 + N_PERIODS * distortion**2
    assert abs(np.trace(total).real / np.trace(noise).real / expected - 1) < 0.04


def test_degrees_of_freedom_are_those_of_spare_experiments_and_neighbours() -> None:
    rng = np.random.default_rng(1)
    G = np.tile(np.eye(3, dtype=complex), (N_LINES, 1, 1))
    spectra = closed_loop_spectra(rng, G, 0.0)
    U, Y = (np.transpose(part.mean(axis=1), (1, 2, 0)) for part in (spectra.input, spectra.output))
    result = estimate(U, Y, None, spectra.block, "joint", spectra.frequency)
    assert abs(error_covariance(spectra, result, 0, 3).degrees_of_freedom - 7 * (9 - 3)) < 1e-6


@pytest.mark.slow
def test_degrees_of_freedom_are_those_of_the_scatter_over_repeated_experiments() -> None:
    """Mean squared over variance of the total covariance of two motors and two blocks, pooled over seven lines."""
    rng, n_lines, totals = np.random.default_rng(2), 30, []
    T = np.array([[1.0, 1.0], [1.0, -1.0]])
    for _ in range(300):
        phases = np.exp(2j * np.pi * rng.random((n_lines, 2, 2)))
        U = 30 * np.einsum("fib,ie->fibe", phases, T).reshape(n_lines, 2, 4)
        Y = U + complex_normal(rng, 2, n_lines, 2, 4)
        spectra = PeriodSpectra(
            lines=np.arange(1, n_lines + 1),
            period=200,
            sample_time=1e-2,
            input=np.transpose(np.broadcast_to(U, Y.shape), (3, 0, 1, 2)),
            output=np.transpose(Y, (3, 0, 1, 2)),
            reference=None,
            block=np.array([0, 0, 1, 1]),
        )
        result = estimate(U, Y.mean(axis=0), None, spectra.block, "joint", spectra.frequency)
        error = error_covariance(spectra, result, 0, 3)
        assert error.total is not None
        totals.append(np.einsum("fii->fi", error.total).real)
    drawn = np.mean(np.mean(totals, axis=0) ** 2 / np.var(totals, axis=0))
    assert abs(error.degrees_of_freedom / drawn - 1) < 0.1


def test_one_block_and_one_period_have_no_covariance() -> None:
    rng = np.random.default_rng(1)
    G = np.tile(np.eye(3, dtype=complex), (N_LINES, 1, 1))
    whole = closed_loop_spectra(rng, G, 0.0)
    first_half = PeriodSpectra(whole.lines, 100, 1e-2, whole.input[:3, :1], whole.output[:3, :1], None, whole.block[:3])
    U, Y = (np.transpose(part.mean(axis=1), (1, 2, 0)) for part in (first_half.input, first_half.output))
    error = error_covariance(first_half, estimate(U, Y, None, first_half.block, "joint", first_half.frequency), 0, 3)
    assert error.noise is None
    assert error.total is None
    assert error.degrees_of_freedom == 0
