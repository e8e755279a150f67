"""Records at another sample time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.record.record import Record
from flexros.record.resampled import at_usual_rate, may_be_resampled, resampled
from flexros.record.shifted_torque import moved_later

N = 2000
OLD = 1 / 100.235


def record_of(sample_time: float = OLD) -> Record:
    time = np.arange(N) * sample_time
    valid = np.ones(N, dtype=bool)
    valid[500] = False
    return Record(
        name="log",
        sample_time=sample_time,
        position=np.sin(2 * np.pi * time)[:, None],
        torque=np.cos(2 * np.pi * time)[:, None],
        valid=valid,
        velocity=time[:, None],
    )


def test_positions_torques_and_speeds_are_those_of_the_new_instants() -> None:
    record = resampled(record_of(), 0.01)
    at = np.arange(record.n_samples) * 0.01
    assert record.sample_time == 0.01
    assert record.duration == pytest.approx(record_of().duration, abs=0.01)
    np.testing.assert_allclose(record.position[:, 0], np.sin(2 * np.pi * at), atol=1e-5)
    np.testing.assert_allclose(record.velocity[:, 0], at, atol=1e-9)
    assert np.abs(record.torque[:, 0] - np.cos(2 * np.pi * at)).max() < 0.07
    assert np.sum(record.torque) * 0.01 == pytest.approx(np.sum(record_of().torque) * OLD, abs=0.02)
    assert 1 <= np.count_nonzero(~record.valid) <= 3
    assert "resampled" in record.warnings[-1]


def test_the_same_rate_changes_nothing() -> None:
    record = record_of(0.01)
    assert resampled(record, 0.010005) is record


@pytest.mark.parametrize(("sample_time", "allowed"), [(0.01, True), (0.02, True), (0.005, False)])
def test_a_rate_is_not_raised_much(sample_time: float, allowed: bool) -> None:
    assert may_be_resampled(record_of(), sample_time) == allowed


def test_a_very_fast_recorder_is_slowed_down_for_an_imported_log_alone() -> None:
    fast = record_of(1 / 5000)
    assert at_usual_rate(fast) is fast
    slow = at_usual_rate(replace(fast, imported=True))
    assert slow.sample_time == pytest.approx(1e-3)
    np.testing.assert_allclose(slow.position, fast.position[::5], atol=1e-9)
    np.testing.assert_allclose(slow.torque[:-1, 0], fast.torque.reshape(-1, 5).mean(axis=1)[:-1])
    assert at_usual_rate(replace(record_of(1 / 2000), imported=True)).sample_time == 1 / 2000


def test_measured_torques_act_when_they_acted_before() -> None:
    fast = record_of(1 / 4000)
    ramp = np.arange(N, dtype=float)[:, None]
    held = replace(fast, imported=True, measured_torque=True, noted=ramp, torque_shift=0.5)
    slow = at_usual_rate(held)
    assert slow.noted is not None
    acting = moved_later(slow.noted, slow.torque_shift)[1:-1]
    np.testing.assert_allclose(acting, 4 * np.arange(1, slow.n_samples - 1)[:, None] - 0.5)
