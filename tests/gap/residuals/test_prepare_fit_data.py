"""Tests of the preparation of logs for fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.noise.weights import measurement_of
from flexros.gap.residuals.observed_model import ObservedModel
from flexros.gap.residuals.prepare_fit_data import fit_data, with_tool_frame_of
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record, ToolRecord
from tests.gap.diagnosis_logs import MODEL, ROBOT, WHOLE, candidates_of, data_of, encoded, predictor_of, record_of

NOTHING = np.zeros((0, 1))


def test_a_log_that_begins_with_a_hole_in_motion_does_not_begin_at_rest() -> None:
    moving = record_of().part(9000, 20_000)
    valid = moving.valid.copy()
    valid[:80] = False
    data = fit_data(replace(moving, valid=valid), MODEL, DiagnosisSettings())
    assert not data.from_rest


@pytest.mark.slow
def test_a_tool_that_was_hardly_seen_is_left_out_with_a_warning() -> None:
    record = record_of(tool=True)
    assert record.tool is not None
    few = ToolRecord(record.tool.time[500:505], record.tool.position[500:505])
    data = fit_data(replace(record, tool=few), MODEL, DiagnosisSettings())
    assert data.tool is None
    assert any(text.startswith("5 poses of the tool") and "20" in text for text in data.record.warnings)
    np.testing.assert_array_equal(data.spread, data_of().spread)


@pytest.mark.slow
def test_a_log_that_begins_in_motion_starts_with_its_state() -> None:
    """Errors of a guess of the state would last for seconds."""
    record = record_of()
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
    again, same = (with_tool_frame_of(data, one, np.zeros(0)) for one in (other, predictor_of()))
    assert data.tool is not None
    assert again.tool is not None
    assert same.tool is not None
    np.testing.assert_allclose(same.tool.position, data.tool.position)
    assert not np.allclose(again.tool.position, data.tool.position, atol=1e-9)
    assert with_tool_frame_of(data_of(), other, np.zeros(0)) is data_of()


def test_a_model_that_is_far_off_is_tied_more_closely_to_the_encoders() -> None:
    friction, settings = "coulomb_friction@motor_1:level=1", DiagnosisSettings()
    strayed = fit_data(record_of(friction), MODEL, settings, torque_noise=settings.level)
    assert strayed.nominal_level > settings.residuals.far_off
    data = data_of(friction)
    assert data.torque_noise > settings.level
    assert data.nominal_level < settings.residuals.far_off
    assert data_of().torque_noise == settings.level


def test_a_measured_log_is_tied_as_its_tolerance_says() -> None:
    record = replace(record_of("coulomb_friction@motor_1:level=1"), imported=True)
    assert fit_data(record, MODEL, DiagnosisSettings()).torque_noise == DiagnosisSettings().level


def test_the_gain_of_the_predictor_settles_early_in_a_short_log() -> None:
    """Where it did not, an exact rigid arm of six axes, sampled every 4 ms, had a coloured prediction error."""
    short, settings = record_of().part(0, 6000), DiagnosisSettings()
    late, data = (fit_data(short, MODEL, settings, torque_noise=level) for level in (settings.level, None))
    longest = settings.residuals.settles_within * short.n_samples
    assert data.gain.settling <= longest < late.gain.settling
    assert data.torque_noise <= 8 * settings.level


@pytest.mark.slow
def test_every_model_finds_its_own_state_in_a_log_that_begins_in_motion() -> None:
    """With that of the nominal model, the errors of a good one would be large for seconds."""
    record = record_of("viscous_friction@motor_1:coefficient=0.5")
    fast = int(np.argmax(np.abs(np.gradient(record.position[: record.n_samples // 2, 0]))))
    data = fit_data(record.part(fast, record.n_samples), MODEL, DiagnosisSettings())
    friction = candidates_of()["viscous_friction@motor_1"]
    theta = np.array(
        encoded(friction, **{one.name: 0.5 if one.name == "coefficient" else 0.0 for one in friction.free})
    )
    residual = data.residuals(predictor_of(friction), theta[:, None])[:, 0]
    assert residual @ residual / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))


def test_a_log_that_is_cut_in_a_motion_does_not_begin_at_rest_however_closely_that_is_followed() -> None:
    """Of a held-out log that moved 0.6 rad/s at its begin half of what was left lay within its first 0.3 s."""
    log, settings = record_of(length=WHOLE), DiagnosisSettings()
    measurement = measurement_of(log, ROBOT, settings)
    speeds = []
    for first in range(200, log.n_samples - 4000, 250):
        part = log.part(first, first + 4000)
        begins = ObservedModel.of(part, MODEL, measurement, settings.residuals).beginning()
        if begins.from_rest:
            speeds.append(abs(float(np.polyfit(np.arange(20) * part.sample_time, part.position[:20, 0], 1)[0])))
    assert speeds
    assert max(speeds) < 0.25
