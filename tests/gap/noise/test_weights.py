"""Weights of prediction errors: their standard deviation by noise alone."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.noise import weights
from flexros.gap.noise.encoder_noise import Noise
from flexros.gap.noise.weights import Measurement, measurement_in, measurement_of, noise_of_positions, spread_of
from flexros.gap.settings import DiagnosisSettings
from flexros.prediction.observer import observer_gain
from tests.gap.diagnosis_logs import ROBOT, WHOLE, record_of
from tests.gap.rigid_arm import arm, record_of_arm

pytestmark = pytest.mark.slow

NOISE = np.array([1e-4])

SETTINGS = DiagnosisSettings()


def measurement(whitening: np.ndarray, jitter: float = 0.0) -> Measurement:
    return Measurement(NOISE, whitening, NOISE, jitter, (), np.zeros(1), 0.0, 0.0, 0.0, ())


def test_noise_as_declared_is_that_of_the_file_and_exact() -> None:
    found = measurement_of(record_of(length=WHOLE), ROBOT, SETTINGS)
    np.testing.assert_array_equal(found.deviation, ROBOT.encoder_noise)
    assert found.floor_error == 0.0
    assert found.doubt < 0.01
    assert found.whitening.tolist() == [[1.0]]
    assert found.quantizations == ()


def test_other_noise_is_measured_and_less_sure() -> None:
    record = record_of()
    more = np.random.default_rng(0).normal(size=record.position.shape) * 2e-4
    found = measurement_of(replace(record, position=record.position + more), ROBOT, SETTINGS)
    assert found.deviation[0] == pytest.approx(np.hypot(1e-4, 2e-4), rel=0.05)
    assert found.floor_error > 0


def test_noise_a_little_off_the_declared_one_is_allowed_for() -> None:
    record = record_of(length=WHOLE)
    more = np.random.default_rng(0).normal(size=record.position.shape) * 0.3e-4
    noisier = replace(record, position=record.position + more)
    found = measurement_of(noisier, ROBOT, SETTINGS)
    np.testing.assert_array_equal(found.deviation, ROBOT.encoder_noise)
    assert (found.floor_error, found.doubt) == (0.0, pytest.approx(0.5 * 0.3**2, rel=0.3))
    elsewhere = measurement_in(noisier, ROBOT, measurement_of(record, ROBOT, SETTINGS), SETTINGS)
    assert (elsewhere.floor_error, elsewhere.doubt) == (0.0, found.doubt)


def test_a_joint_without_a_drive_tolerates_a_share_of_its_weight() -> None:
    driven = record_of_arm(imported=True)
    passive = replace(driven, torque=driven.torque * [1.0, 0.0])
    found = measurement_of(passive, arm(), SETTINGS).tolerated_torque(passive)
    angle = passive.position.sum(axis=1)
    weight = 3 * 9.81 * 0.15 * np.std(np.cos(angle))
    assert found[1] == pytest.approx(0.05 * weight, rel=0.2)
    assert found[0] == pytest.approx(0.05 * np.std(driven.torque[:, 0]))


@pytest.mark.parametrize(("changing", "tolerated"), [(0.0, 0.3), (0.2, 0.3), (0.5, 0.5)])
def test_a_torque_that_hardly_changes_is_tolerated_as_in_the_first_log(changing: float, tolerated: float) -> None:
    """As that of a motor which holds a weight in the log that is held out."""
    first = replace(measurement(np.ones((1, 1))), signal_tolerance=0.05, torque=np.array([2.0]))
    torque = 9.0 + 2.0 * changing * np.where(np.arange(100) % 2, 1.0, -1.0)
    record: Any = SimpleNamespace(torque=torque[:, None])
    assert first.tolerated_torque(record) == pytest.approx(0.05 * 2.0 * np.array([tolerated]))


def test_rounding_adds_its_own_noise() -> None:
    record = record_of()
    step = 1e-3
    found = measurement_of(replace(record, position=step * np.round(record.position / step)), ROBOT, SETTINGS)
    assert found.quantizations[0].step == pytest.approx(step, rel=1e-3)
    assert found.deviation[0] == pytest.approx(np.hypot(1e-4, step / np.sqrt(12)), rel=1e-3)


def test_noise_that_was_measured_contains_its_rounding_already() -> None:
    record, step = record_of(), 1e-4
    more = np.random.default_rng(0).normal(size=record.position.shape) * 2e-4
    rounded = replace(record, position=step * np.round((record.position + more) / step))
    found = measurement_of(rounded, ROBOT, SETTINGS)
    assert found.quantizations[0].step == pytest.approx(step, rel=1e-3)
    assert found.deviation[0] == pytest.approx(np.sqrt(1e-8 + 4e-8 + step**2 / 12), rel=0.02)
    assert found.rounding[0] == pytest.approx(step**2 / 12 / found.deviation[0] ** 2)


def test_rounding_at_one_encoder_is_no_doubt_about_the_others() -> None:
    """Rounding at one motor of six hid a gain of torques at another one that was worth 150."""
    robot, record = arm().with_values({"encoder_noise": 1e-6}), record_of_arm(simulated=True)
    rounded, step = record.position.copy(), 1e-5
    rounded[:, 1] = step * np.round(rounded[:, 1] / step)
    found = measurement_of(replace(record, position=rounded), robot, SETTINGS)
    assert found.rounding[0] == 0.0
    assert found.rounding[1] > 0.5
    assert found.floor_error == pytest.approx(SETTINGS.noise.rounding_error * found.rounding[1] / 2)


def test_coloured_noise_is_driven_by_less_white_noise() -> None:
    """A first-order autoregression a amplifies by 1 / sqrt(1 - a^2)."""
    rng = np.random.default_rng(0)
    white = rng.normal(size=40_000)
    coloured = np.zeros_like(white)
    for k in range(1, len(white)):
        coloured[k] = 0.6 * coloured[k - 1] + white[k]
    record = replace(record_of(), position=1e-3 * coloured[:, None], torque=np.zeros((40_000, 1)))
    record = replace(record, valid=np.ones(40_000, dtype=bool), reference=None)
    found = measurement_of(record, ROBOT, SETTINGS)
    assert found.deviation[0] / found.driving[0] == pytest.approx(1 / 0.8, rel=0.05)
    assert found.whitening[0, 1] == pytest.approx(-0.6, abs=0.06)


def test_the_start_and_what_was_not_measured_do_not_count() -> None:
    gain = observer_gain(ROBOT, ROBOT.sample_time, 1e-3, NOISE)
    record = record_of()
    valid = record.valid.copy()
    valid[9000:9010] = False
    whitening = np.array([[1.0, -0.5, 0.1]])
    spread = spread_of(replace(record, valid=valid), gain, measurement(whitening))
    assert np.all(np.isinf(spread[: gain.settling]))
    assert np.all(np.isfinite(spread[gain.settling : 9000]))
    assert np.all(np.isinf(spread[9000:9012]))  # the filter carries them on
    assert np.all(np.isfinite(spread[9012:]))
    np.testing.assert_allclose(spread[gain.settling : 9000], gain.spread[0])


def test_a_log_from_rest_counts_from_its_first_sample() -> None:
    """Behind a known start there is less noise than later."""
    gain, record = observer_gain(ROBOT, ROBOT.sample_time, 1e-3, NOISE), record_of()
    rested, moving = (
        spread_of(record, gain, measurement(np.ones((1, 1))), from_rest=from_rest) for from_rest in (True, False)
    )
    assert rested[0, 0] == pytest.approx(NOISE[0])
    assert np.all(np.diff(rested[: gain.settling, 0]) >= 0)
    np.testing.assert_allclose(rested[gain.settling :], moving[gain.settling :])


def test_whitening_needs_what_was_before() -> None:
    gain = observer_gain(ROBOT, ROBOT.sample_time, 1e-3, NOISE)
    spread = spread_of(record_of(), gain, measurement(np.array([[1.0, -0.5, 0.1]])), from_rest=True)
    np.testing.assert_array_equal(np.isinf(spread[:4, 0]), [True, True, False, False])


def test_jitter_adds_noise_where_the_motor_is_fast() -> None:
    gain = observer_gain(ROBOT, ROBOT.sample_time, 1e-3, NOISE)
    record = record_of()
    plain, jittered = (spread_of(record, gain, measurement(np.ones((1, 1)), jitter))[:, 0] for jitter in (0.0, 2e-5))
    speed = np.abs(np.gradient(record.position[:, 0], record.sample_time))
    fast = np.convolve(speed, np.ones(51) / 51, mode="same").argmax()
    assert jittered[fast] == pytest.approx(np.hypot(plain[fast], 2e-5 * speed[fast - 25 : fast + 26].mean()), rel=0.1)
    still = np.isfinite(plain) & (np.abs(record.position[:, 0] - record.position[0, 0]) < 1e-3)
    assert np.median(jittered[still] / plain[still]) < 1.2


def test_little_noise_above_the_band_of_a_log_without_rest_is_coloured(monkeypatch: pytest.MonkeyPatch) -> None:
    """An autoregression of 0.75 and the declared power has 0.38 of the declared deviation at the upper end."""
    declared = ROBOT.encoder_noise
    seen = Noise(0.378 * declared, np.zeros((1, 0)), 0.0, ("above the band",))
    monkeypatch.setattr(weights, "measure_noise", lambda *_: seen)
    found = weights.measurement_of(record_of(), ROBOT, SETTINGS)
    assert found.deviation == pytest.approx(declared)
    assert found.whitening[0, 1] == pytest.approx(-0.75, abs=0.01)
    assert found.driving == pytest.approx(declared * np.sqrt(1 - 0.75**2), rel=0.01)
    assert found.floor_error == SETTINGS.noise.coloured_error


def test_a_robot_file_without_noise_takes_that_of_the_log() -> None:
    silent = copy(ROBOT)
    silent.__dict__["encoder_noise"] = np.zeros(1)
    found = measurement_of(record_of(), silent, SETTINGS)
    assert found.deviation[0] == pytest.approx(1e-4, rel=0.3)
    assert found.floor_error > 0
    assert any("declares no encoder noise" in text for text in found.warnings)


def test_noise_of_motors_that_are_not_predicted_is_not_said() -> None:
    record = record_of_arm(imported=True)
    position = record.position.copy()
    position[:, 0] = 0.1654815673828125
    still = replace(record, position=position, torque=record.torque * [0.0, 1.0], prescribed=(0,))
    (said,) = (text for text in measurement_of(still, arm(), SETTINGS).warnings if "declares no encoder noise" in text)
    assert "motor_2: " in said
    assert "motor_1" not in said


@pytest.mark.parametrize(("noise", "moves", "said"), [(1e-10, True, True), (1e-8, True, False), (1e-10, False, False)])
def test_positions_without_the_noise_of_an_encoder_are_said_of_joints_that_move(
    noise: float, moves: bool, said: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    silent = copy(ROBOT)
    silent.__dict__["encoder_noise"] = np.zeros(1)
    seen = Noise(np.array([noise]), np.zeros((1, 0)), 0.0, ("above the band",))
    monkeypatch.setattr(weights, "measure_noise", lambda *_: seen)
    monkeypatch.setattr(weights, "encoder_step", lambda *_: 0.0)
    record = record_of()
    record = record if moves else replace(record, position=1e-5 * record.position)
    found = weights.measurement_of(record, silent, SETTINGS)
    assert any("have less noise than any encoder" in text for text in found.warnings) is said


def off_instants(usual: float) -> Measurement:
    """Noise of which the instants add a multiple of that of the encoder at the usual speed of the log."""
    once = weights.off_instants(record_of(), measurement(np.ones((1, 1)), jitter=1.0))
    assert once is not None
    return measurement(np.ones((1, 1)), jitter=usual * NOISE[0] / float(np.median(once)))


@pytest.mark.parametrize(("usual", "noise"), [(2.0, 1.0), (5.0, np.hypot(1.0, 5.0))])
def test_the_gain_allows_for_uneven_instants_where_these_dominate(usual: float, noise: float) -> None:
    np.testing.assert_allclose(noise_of_positions(record_of(), off_instants(usual)), noise * NOISE)


def test_a_gain_that_allows_for_uneven_instants_is_not_counted_twice() -> None:
    """What noise leaves in the states is that of the gain, and each sample has its own noise by its speed."""
    record, noisy = record_of(), off_instants(5.0)
    gain = observer_gain(ROBOT, ROBOT.sample_time, 2e-4, noise_of_positions(record, noisy))
    spread, added = spread_of(record, gain, noisy), weights.off_instants(record, noisy)
    assert added is not None
    rows = np.isfinite(spread[:, 0])
    in_states = gain.spread**2 - gain.noise**2
    np.testing.assert_allclose((spread**2)[rows], (in_states + NOISE**2 + added**2)[rows])
