"""Weighted least squares and the honesty of its standard deviations."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from flexros.identify.rigid.least_squares import (
    condition_number,
    correlation_length,
    covariance,
    long_run,
    weighted_least_squares,
)


def problem(n: int = 400, seed: int = 1) -> np.ndarray:
    """Slow columns, as those of a motion are."""
    rng = np.random.default_rng(seed)
    return lfilter([1], [1, -0.95], rng.normal(size=(n, 2, 3)), axis=0)


def test_exact_torques_give_exact_parameters() -> None:
    H, true = problem(), np.array([3.0, -2e3, 1e-3])
    solution = weighted_least_squares(H, H @ true, 400)
    np.testing.assert_allclose(solution.values, true, rtol=1e-9)


def test_motor_with_the_larger_residual_counts_less() -> None:
    rng = np.random.default_rng(2)
    H, true = problem(), np.array([1.0, 2.0, 3.0])
    noise = rng.normal(size=(400, 2)) * [1e-3, 10.0]
    weighted = weighted_least_squares(H, H @ true + noise, 400)
    assert np.abs(weighted.values - true).max() < 1e-3
    assert 5e3 < weighted.deviation[1] / weighted.deviation[0] < 2e4


def test_standard_deviations_cover_correlated_residuals() -> None:
    rng = np.random.default_rng(3)
    H, true = problem(), np.array([1.0, 2.0, 3.0])
    scores = []
    plain = []
    for _ in range(150):
        noise = lfilter([1], [1, -0.9], rng.normal(size=(400, 2)), axis=0)
        solution = weighted_least_squares(H, H @ true + noise, 400)
        residual = H @ (true - solution.values) + noise
        spread = covariance(solution, np.einsum("nmk,nm->nk", H, residual / solution.deviation**2), residual)
        scores.append((solution.values - true) / np.sqrt(np.diag(spread)))
        white = np.linalg.inv(np.einsum("nmi,nmj->ij", H, H)) * residual.var()
        plain.append((solution.values - true) / np.sqrt(np.diag(white)))
    assert 0.8 < np.std(scores) < 1.45
    assert np.std(plain) > 2.0  # what the usual formula would have promised


def test_sum_over_lags_is_that_of_the_definition() -> None:
    moments, lags = np.random.default_rng(5).normal(size=(60, 3)), 7
    expected = moments.T @ moments
    for lag in range(1, lags + 1):
        part = moments[lag:].T @ moments[:-lag]
        expected += (1 - lag / (lags + 1)) * (part + part.T)
    np.testing.assert_allclose(long_run(moments, lags), expected, rtol=1e-10, atol=1e-12)


def test_rows_may_be_replaced_by_their_triangular_factor() -> None:
    H, noise = problem(), np.random.default_rng(6).normal(size=(400, 2)) * [0.1, 5.0]
    y = H @ [1.0, 2.0, 3.0] + noise
    R = np.linalg.qr(np.concatenate([H, y[:, :, None]], axis=2).transpose(1, 0, 2), mode="r").transpose(1, 0, 2)
    whole, reduced = weighted_least_squares(H, y, 400), weighted_least_squares(R[:, :, :3], R[:, :, 3], 400)
    np.testing.assert_allclose(reduced.values, whole.values, rtol=1e-9)
    np.testing.assert_allclose(reduced.bread, whole.bread, rtol=1e-8)
    np.testing.assert_allclose(reduced.deviation, whole.deviation, rtol=1e-8)


def test_correlation_length() -> None:
    rng = np.random.default_rng(4)
    white = rng.normal(size=(3000, 1))
    slow = lfilter([1], [1, -0.98], rng.normal(size=(3000, 1)), axis=0)
    assert correlation_length(white) < 20
    assert correlation_length(slow) > 60
    assert correlation_length(np.hstack([white, slow])) == correlation_length(slow)


def test_condition_number_does_not_depend_on_units() -> None:
    H = problem()
    one = np.ones(2)
    np.testing.assert_allclose(condition_number(H, one), condition_number(H * [1, 1e6, 1e-3], one), rtol=1e-9)
    assert condition_number(np.eye(4).reshape(2, 2, 4), one) == 1


def test_torque_that_is_zero_throughout_leaves_finite_numbers() -> None:
    H = np.random.default_rng(5).normal(size=(400, 2, 3))
    H[:, 0, 2] = H[:, 1, :2] = 0.0  # the last parameter acts on the second motor alone
    torque = np.column_stack([H[:, 0] @ np.array([1.0, 2.0, 0.0]), np.zeros(400)])
    solution = weighted_least_squares(H, torque, 400)
    np.testing.assert_allclose(solution.values, [1.0, 2.0, 0.0], atol=1e-9)
    assert np.isfinite(condition_number(H, solution.deviation))
