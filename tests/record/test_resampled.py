"""Records at another sample time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.rigid.record import torque_at_samples
from flexros.record.record import Record
from flexros.record.resampled import at_usual_rate, may_be_resampled, resampled, with_fewer_samples
from flexros.record.torques.shifted_torque import HELD, shifted

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


@pytest.mark.parametrize(("sample_time", "allowed"), [(0.01, True), (0.02, True), (0.0085, True), (0.008, False)])
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
    assert slow.recorder_samples == pytest.approx(4.0)
    np.testing.assert_allclose(torque_at_samples(slow)[2:-1, 0], 4 * np.arange(2, slow.n_samples - 1) - 0.5)


def test_noted_torques_shift_by_samples_of_their_recorder() -> None:
    fast = record_of(1 / 4000)
    held = replace(fast, imported=True, noted=fast.torque, torque_shift=HELD)
    slow = shifted(at_usual_rate(held), -HELD)
    earlier = shifted(held, -HELD).torque.reshape(-1, 4).mean(axis=1)
    np.testing.assert_allclose(slow.torque[1:-1, 0], earlier[1:-1], atol=2e-5)


def test_positions_stay_near_those_of_the_record_where_none_were_measured() -> None:
    record = record_of(1e-3)
    valid = record.valid.copy()
    valid[:400], valid[-300:] = False, False
    slow = resampled(replace(record, valid=valid), 5e-3)
    np.testing.assert_allclose(slow.position, record.position[::5], atol=1e-6)


def test_fewer_samples_are_taken_down_to_the_lowest_rate() -> None:
    record = record_of(1e-3)
    assert with_fewer_samples(record, N, 100.0, "a test") is record
    assert with_fewer_samples(record, N // 2, 100.0, "a test").sample_time == pytest.approx(2e-3)
    assert with_fewer_samples(record, N // 100, 100.0, "a test").sample_time == pytest.approx(10e-3)
    assert with_fewer_samples(record, 1, 600.0, "a test") is record


@pytest.mark.parametrize("lost", [0, 500, 502, 504, N - 1])
def test_a_sample_is_late_where_any_within_it_is(lost: int) -> None:
    late = np.zeros(N, dtype=bool)
    late[lost] = True
    slow = resampled(replace(record_of(1e-3), late=late), 5e-3)
    assert slow.late is not None
    np.testing.assert_array_equal(np.flatnonzero(slow.late), [lost // 5])
