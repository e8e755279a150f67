"""Positions that are cut off or jump."""

from __future__ import annotations

import numpy as np
import pytest


def test_few_clipped_samples_do_not_count(found, healthy) -> None:
    record = healthy("emps")
    level = float(np.quantile(record.position, 0.98))
    (finding,) = (one for one in found("emps", position=np.minimum(record.position, level)) if one.spoilt is not None)
    assert not finding.hopeless
    assert "stays at the end of its range in" in finding.text
    assert 0.01 * record.n_samples < finding.spoilt.sum() < 0.03 * record.n_samples


def test_mostly_clipped_is_refused(found, healthy) -> None:
    record = healthy("emps")
    level = float(np.quantile(record.position, 0.8))
    finding = found("emps", position=np.minimum(record.position, level))[0]
    assert finding.hopeless
    assert "the encoder or the recorder clips it" in finding.text


def test_encoder_that_wraps_around_is_refused(found, healthy) -> None:
    record = healthy("elbow")
    position = record.position.copy()
    turn = float(np.ptp(position[:, 0])) * 2
    position[10_000:, 0] += turn
    finding = found("elbow", position=position)[0]
    assert finding.hopeless
    assert "the position of motor_1 jumps by" in finding.text
    assert "'period' in the mapping" in finding.text


def test_encoder_that_is_reset_in_fast_motion_is_refused(found, healthy) -> None:
    """Half of its steps are a hundredth of its range and more."""
    position = healthy("elbow").position.copy()
    position[:, 0] = 20.0 * np.sin(0.2 * np.arange(len(position)))
    position[10_000:, 0] += 100.0
    assert np.median(np.abs(np.diff(position[:, 0]))) > 0.01 * np.ptp(position[:, 0])
    assert "the position of motor_1 jumps by" in found("elbow", position=position)[0].text


def test_noise_of_a_motor_at_rest_that_jumps_is_no_range_of_an_encoder(found, healthy) -> None:
    """As of a fine encoder whose controller filters it."""
    position = healthy("elbow").position.copy()
    position[:, 0] = 0.3 + 3e-6 * (np.arange(len(position)) > 10_000)
    position[:, 0] += 6e-8 * np.random.default_rng(1).integers(0, 2, len(position))
    assert not any("jumps by" in finding.text for finding in found("elbow", position=position))


def test_motor_that_moves_on_in_a_hole_of_the_log_does_not_wrap_around(found, healthy) -> None:
    """A motor that turns far while two seconds are missing is elsewhere behind the hole."""
    record = healthy("elbow")
    position, valid = record.position.copy(), record.valid.copy()
    hole = slice(10_000, 14_000)
    position[hole], valid[hole] = position[hole.start], False
    position[hole.stop :, 0] += 2 * float(np.ptp(position[:, 0]))
    assert not any("jumps" in finding.text for finding in found("elbow", position=position, valid=valid))
    valid[:] = True
    assert any("jumps" in finding.text for finding in found("elbow", position=position, valid=valid))


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_encoder_of_a_joint_at_rest_does_not_wrap_around(found, healthy, noise: float) -> None:
    """A coarse encoder of a joint that stands still changes by one step, all its range."""
    record = healthy("elbow")
    position = record.position.copy()
    position[:, 1] = position[0, 1] + 1e-4 * (np.arange(record.n_samples) > record.n_samples // 2)
    position[:, 1] += 1e-4 * np.rint(noise * np.random.default_rng(1).normal(size=record.n_samples))
    assert not any("jumps" in finding.text for finding in found("elbow", position=position))


def test_turning_point_of_a_coarse_encoder_is_not_clipped(found, healthy) -> None:
    record = healthy("emps")
    time = np.arange(record.n_samples) * record.sample_time
    position = 0.04 * np.cos(2 * np.pi * 0.31 * time) + 0.01 * np.cos(2 * np.pi * 0.083 * time)
    position = 1e-6 * np.round(position[:, None] / 1e-6)
    assert len(np.unique(position)) > 0.5 * len(position)
    assert not any("stays at the end" in finding.text for finding in found("emps", position=position))
    clipped = np.minimum(position, 0.045)
    assert any("stays at the end" in finding.text for finding in found("emps", position=clipped))


def test_encoder_that_changes_once_is_at_rest(found, healthy) -> None:
    record = healthy("elbow")
    position = record.position.copy()
    position[:, 1] = position[0, 1] + 1e-4 * (np.arange(record.n_samples) > record.n_samples - 50)
    texts = [finding.text for finding in found("elbow", position=position)]
    assert not any("jumps" in text or "repeats its value" in text for text in texts)


def test_turning_point_of_numbers_with_few_digits_is_not_clipped(found, healthy) -> None:
    """Positions of the motor side above 100 rad with five digits, as a recorder writes them, have no common step."""
    record = healthy("emps")
    time = np.arange(record.n_samples) * record.sample_time
    motion = 120 * np.cos(2 * np.pi * 0.31 * time) + 30 * np.cos(2 * np.pi * 0.083 * time)
    position = np.array([[float(f"{one:.5g}")] for one in motion])
    assert not any("stays at the end" in finding.text for finding in found("emps", position=position / 3000))
    clipped = np.minimum(position, 135)
    assert any("stays at the end" in finding.text for finding in found("emps", position=clipped / 3000))


def test_motor_that_rests_at_its_end_before_a_hole_is_not_clipped(found, healthy) -> None:
    record = healthy("emps")
    position, valid = record.position.copy(), record.valid.copy()
    at = int(np.argmax(position[:, 0]))
    position[at - 20 : at + 1] = position[at]
    assert any("stays at the end" in finding.text for finding in found("emps", position=position))
    valid[at + 1 : at + 2_000] = False
    assert not any("stays at the end" in finding.text for finding in found("emps", position=position, valid=valid))


@pytest.mark.parametrize("leaves", [False, True])
def test_motor_that_friction_stops_at_once_is_not_clipped(found, healthy, leaves: bool) -> None:
    """It turns back slowly from where it stuck, or leaves at once; a clipped position comes back as fast as it went."""
    record = healthy("emps")
    time = np.arange(record.n_samples) * record.sample_time - 5.0
    motion = 0.04 * np.cos(2 * np.pi * 0.31 * time) + 0.01 * np.cos(2 * np.pi * 0.083 * time)
    top = int(np.argmax(motion))
    coming = np.minimum(motion[top] - 2e-5 * np.arange(top, 0, -1), motion[:top])
    position = np.concatenate([coming, np.full(40, motion[top]), motion[top:-40]])[:: -1 if leaves else 1, None]
    position = 2e-6 * np.round(position / 2e-6)
    assert not any("stays at the end" in finding.text for finding in found("emps", position=position))
    clipped = np.minimum(position, 0.9 * position.max())
    assert any("stays at the end" in finding.text for finding in found("emps", position=clipped))
