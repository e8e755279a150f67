"""Logs as a fit sees them: weighted errors of motors and tool."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import MODEL, candidates_of, data_of, encoded, predictor_of, record_of

NOTHING = np.zeros((0, 1))


def test_errors_that_do_not_count_are_zero() -> None:
    record = record_of()
    valid = record.valid.copy()
    valid[15_000:15_010] = False
    data = fit_data(replace(record, valid=valid), MODEL, DiagnosisSettings())
    residual = data.residuals(predictor_of(), np.zeros((0, 1)))[:, 0]
    np.testing.assert_array_equal(residual == 0.0, ~valid)
    assert data.initial_state_errors is not None
    assert data.n_values == valid.sum() - data.initial_state_errors.number


def test_what_noise_leaves_of_the_floor_of_a_measured_log() -> None:
    """A right model of a log with noise and no errors of torques leaves that, and not what is tolerated."""
    exact = data_of()
    assert exact.noise_level == pytest.approx(1.0)
    tolerant = fit_data(replace(record_of(), imported=True), MODEL, DiagnosisSettings())
    residual = tolerant.residuals(predictor_of(), NOTHING)[:, 0]
    assert 0.0 < tolerant.noise_level < 0.99
    assert np.sum(residual**2) / tolerant.n_values == pytest.approx(tolerant.noise_level, rel=0.03)


def test_weighted_errors_are_errors_over_their_spread() -> None:
    data = data_of()
    errors = np.random.default_rng(0).normal(size=(data.record.n_samples, 1, 3))
    counted = np.isfinite(data.spread[:, 0])
    expected = errors[counted, 0] / data.spread[counted]
    np.testing.assert_allclose(data.weighted(errors)[counted], expected)


def test_squares_in_parts_of_a_log_add_up_with_those_of_its_torques() -> None:
    data = data_of()
    n = data.record.n_samples
    data = replace(data, torques=SimpleNamespace(size=n // 10))
    residual = np.arange(n + n // 10, dtype=float)
    parts = data.squares_in_time(residual, 4)
    assert parts.sum() == pytest.approx(np.sum(residual**2))
    first = np.array_split(residual[:n], 4)[0], np.array_split(residual[n:], 4)[0]
    assert parts[0] == pytest.approx(sum(np.sum(part**2) for part in first))


def test_coloured_noise_becomes_white() -> None:
    data = data_of()
    whitening = np.array([[1.0, -0.6]])
    coloured = replace(
        data, spread=np.ones_like(data.spread), measurement=replace(data.measurement, whitening=whitening)
    )
    white = np.random.default_rng(0).normal(size=data.record.n_samples)
    noise = lfilter([1.0], whitening[0], white)
    np.testing.assert_allclose(coloured.weighted(noise[:, None, None])[:, 0], white, atol=1e-9)


@pytest.mark.slow
def test_errors_of_the_tool_stand_behind_those_of_the_motors() -> None:
    motors, both = data_of(), data_of(tool=True)
    assert both.tool is not None
    theta = np.zeros((0, 1))
    residual = both.residuals(predictor_of(), theta)[:, 0]
    n, late = both.record.n_samples, 2 * both.gain.settling
    np.testing.assert_allclose(residual[late:n], motors.residuals(predictor_of(), theta)[late:, 0])
    assert len(residual) == n + both.tool.position.size
    assert both.initial_state_errors is not None
    assert both.n_values == n + both.tool.position.size - both.tool.basis.shape[1] - both.initial_state_errors.number
    assert residual @ residual / both.n_values == pytest.approx(1.0, abs=4 * np.sqrt(2 / both.n_values))


def test_sets_have_residuals_of_their_own() -> None:
    friction = candidates_of()["coulomb_friction@motor_1"]
    predictor, data = predictor_of(friction), data_of()
    thetas = np.array([encoded(friction, level=level) for level in (0.01, 0.1)]).T
    together = data.residuals(predictor, thetas)
    for k in range(2):
        np.testing.assert_allclose(together[:, k], data.residuals(predictor, thetas[:, k : k + 1])[:, 0])
