"""White noise of measured torques is measured and taken out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.record.record import Record
from flexros.record.resampled import resampled
from flexros.record.torques.torque_noise import without_torque_noise
from tests.gap.rigid_arm import arm, record_of_arm

NOISE = np.array([2.0, 0.01])
"""Of the torques: a tenth of their rms, and next to nothing [Nm]."""


def noisy(**changes: object) -> tuple[Record, FloatArray]:
    """Return a log with noise on its torques, and the torques without it."""
    record = record_of_arm(imported=True)
    noise = NOISE * np.random.default_rng(3).standard_normal(record.torque.shape)
    measured = record.torque + noise
    return replace(record, torque=measured, noted=measured, **changes), record.torque  # type: ignore[arg-type]


def test_noise_is_that_of_the_log() -> None:
    found = without_torque_noise(noisy()[0], arm())
    assert found.torque_noise is not None
    assert found.torque_noise[0] == pytest.approx(NOISE[0], rel=0.1)


def test_what_is_left_of_it_is_small_and_not_late() -> None:
    record, acting = noisy()
    found = without_torque_noise(record, arm())
    rest = found.torque[:, 0] - acting[:, 0]
    assert np.std(rest) < 0.5 * NOISE[0]
    rate = np.gradient(acting[:, 0])
    assert abs(rest @ rate / (rate @ rate)) < 0.1  # samples by which it is late
    np.testing.assert_array_equal(found.torque, found.noted)
    assert any("motor_1:" in text and "motor_2" not in text for text in found.warnings)


def test_a_quiet_torque_stays() -> None:
    record, _ = noisy()
    np.testing.assert_array_equal(without_torque_noise(record, arm()).torque[:, 1], record.torque[:, 1])


def test_shocks_are_no_noise() -> None:
    """A stop that is hit now and then has a white spectrum."""
    record = record_of_arm(imported=True)
    shocks = np.zeros_like(record.torque)
    shocks[::80, 0] = 40.0
    torque = record.torque + shocks
    shaken = replace(record, torque=torque, noted=torque)
    np.testing.assert_array_equal(without_torque_noise(shaken, arm()).torque, torque)


@pytest.mark.parametrize("changes", [{"measured_torque": False}, {"imported": False}])
def test_commands_and_our_own_simulations_stay(changes: dict[str, bool]) -> None:
    record, _ = noisy(**changes)
    assert without_torque_noise(record, arm()) is record


def test_a_short_log_shows_none() -> None:
    record = noisy()[0].part(0, 1000)
    assert without_torque_noise(record, arm()).torque_noise is None


def test_holes_do_not_count() -> None:
    record, _ = noisy()
    torque, valid = record.torque.copy(), np.ones(record.n_samples, dtype=bool)
    valid[1500:1510], torque[1500:1510] = False, 1e3
    found = without_torque_noise(replace(record, torque=torque, noted=torque, valid=valid), arm())
    assert found.torque_noise is not None
    assert found.torque_noise[0] == pytest.approx(NOISE[0], rel=0.1)


def test_means_over_more_samples_have_less() -> None:
    found = without_torque_noise(noisy()[0], arm())
    fewer = resampled(found, 4 * found.sample_time)
    assert found.torque_noise is not None
    assert fewer.torque_noise is not None
    np.testing.assert_allclose(fewer.torque_noise, found.torque_noise / 2)


def test_a_torque_in_all_bands_that_moves_the_motor_is_no_noise() -> None:
    """As that of a chirp, or of a controller that follows the noise of encoders."""
    record = record_of_arm(imported=True)
    broad = 5.0 * np.random.default_rng(8).standard_normal(record.n_samples)
    torque, position = record.torque.copy(), record.position.copy()
    torque[:, 0] += broad
    position[:, 0] += np.cumsum(np.cumsum(broad - broad.mean())) * record.sample_time**2
    shaken = replace(record, torque=torque, noted=torque, position=position)
    found = without_torque_noise(shaken, arm())
    assert found.torque_noise is not None
    assert found.torque_noise[0] < 0.5
    np.testing.assert_array_equal(found.torque, torque)
