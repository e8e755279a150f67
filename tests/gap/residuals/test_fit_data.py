"""Logs as a fit sees them: weighted errors of motors and tool."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from flexros.effects import RobotWithEffects
from flexros.gap.residuals.fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record, ToolRecord
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, encoded, predictor_of, record_of

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


def test_a_log_that_begins_with_a_hole_in_motion_does_not_begin_at_rest() -> None:
    moving = record_of().part(9000, 20_000)
    valid = moving.valid.copy()
    valid[:80] = False
    data = fit_data(replace(moving, valid=valid), MODEL, DiagnosisSettings())
    assert not data.from_rest


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


@pytest.mark.slow
def test_a_tool_that_was_hardly_seen_is_left_out_with_a_warning() -> None:
    record = record_of(tool=True)
    assert record.tool is not None
    few = ToolRecord(record.tool.time[500:505], record.tool.position[500:505])
    data = fit_data(replace(record, tool=few), MODEL, DiagnosisSettings())
    assert data.tool is None
    assert any(text.startswith("5 poses of the tool") and "20" in text for text in data.record.warnings)
    np.testing.assert_array_equal(data.spread, data_of().spread)


def test_sets_have_residuals_of_their_own() -> None:
    friction = candidates_of()["coulomb_friction@motor_1"]
    predictor, data = predictor_of(friction), data_of()
    thetas = np.array([encoded(friction, level=level) for level in (0.01, 0.1)]).T
    together = data.residuals(predictor, thetas)
    for k in range(2):
        np.testing.assert_allclose(together[:, k], data.residuals(predictor, thetas[:, k : k + 1])[:, 0])


@pytest.mark.slow
def test_a_log_that_begins_in_motion_starts_with_its_state() -> None:
    """Errors of a guess of the state would last for seconds."""
    record = record_of(length=10.0)
    fast = int(np.argmax(np.abs(np.gradient(record.position[: record.n_samples // 2, 0]))))
    part: Record = record.part(fast, record.n_samples)
    data = fit_data(part, MODEL, DiagnosisSettings())
    residual = data.residuals(predictor_of(), np.zeros((0, 1)))[:, 0]
    assert data.record.n_samples < part.n_samples
    assert data.initial_state_errors is None
    assert not np.any(data.counted[: data.gain.settling])
    assert residual @ residual / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))


def test_a_log_that_begins_with_a_start_from_rest_loses_nothing() -> None:
    record, noise = record_of(), float(ROBOT.encoder_noise[0])
    steps = np.abs(record.position[40:, 0] - record.position[:-40, 0])
    part = record.part(int(np.argmax(steps > 15 * noise)), record.n_samples)
    assert np.ptp(part.position[:40]) > 10 * noise
    data = fit_data(part, MODEL, DiagnosisSettings())
    residual = data.residuals(predictor_of(), np.zeros((0, 1)))[:, 0]
    assert data.record.n_samples == part.n_samples
    assert residual @ residual / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))


@pytest.mark.slow
def test_the_frame_of_a_tracker_is_that_of_the_prediction_it_is_seen_by() -> None:
    data = data_of(tool=True)
    softer = ROBOT.with_values({"body_1.rz.stiffness": 0.9 * ROBOT.parameters["body_1.rz.stiffness"].value})
    other = predictor_of(model=RobotWithEffects(softer, ()))
    again, same = (data.with_tool_frame_of(one, np.zeros(0)) for one in (other, predictor_of()))
    assert data.tool is not None
    assert again.tool is not None
    assert same.tool is not None
    np.testing.assert_allclose(same.tool.position, data.tool.position)
    assert not np.allclose(again.tool.position, data.tool.position, atol=1e-9)
    assert data_of().with_tool_frame_of(other, np.zeros(0)) is data_of()


def test_a_model_that_is_far_off_is_tied_more_closely_to_the_encoders() -> None:
    friction, settings = "coulomb_friction@motor_1:level=1", DiagnosisSettings()
    strayed = fit_data(record_of(friction), MODEL, settings, level=settings.level)
    assert strayed.nominal_level > settings.residuals.far_off
    data = data_of(friction)
    assert data.level > settings.level
    assert data.nominal_level < settings.residuals.far_off
    assert data_of().level == settings.level


def test_a_measured_log_is_tied_as_its_tolerance_says() -> None:
    record = replace(record_of("coulomb_friction@motor_1:level=1"), imported=True)
    assert fit_data(record, MODEL, DiagnosisSettings()).level == DiagnosisSettings().level


def test_the_gain_of_the_predictor_settles_early_in_a_short_log() -> None:
    """Where it did not, an exact rigid arm of six axes, sampled every 4 ms, had a coloured prediction error."""
    short, settings = record_of().part(0, 6000), DiagnosisSettings()
    late, data = (fit_data(short, MODEL, settings, level=level) for level in (settings.level, None))
    longest = settings.residuals.settles_within * short.n_samples
    assert data.gain.settling <= longest < late.gain.settling
    assert data.level <= 8 * settings.level


@pytest.mark.slow
def test_every_model_finds_its_own_state_in_a_log_that_begins_in_motion() -> None:
    """With that of the nominal model, the errors of a good one would be large for seconds."""
    record = record_of("viscous_friction@motor_1:coefficient=0.5", length=10.0)
    fast = int(np.argmax(np.abs(np.gradient(record.position[: record.n_samples // 2, 0]))))
    data = fit_data(record.part(fast, record.n_samples), MODEL, DiagnosisSettings())
    friction = candidates_of()["viscous_friction@motor_1"]
    theta = np.array(
        encoded(friction, **{one.name: 0.5 if one.name == "coefficient" else 0.0 for one in friction.free})
    )
    residual = data.residuals(predictor_of(friction), theta[:, None])[:, 0]
    assert residual @ residual / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))
