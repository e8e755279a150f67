"""A recorder that polls a controller takes some values twice and misses others; the motion tells which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray, IntArray
from flexros.logs.time_series import JointSeries, Log
from flexros.record.polled_source import polled_source, recovered

PERIOD = 1e-3
N = 8000


def motion(time: FloatArray) -> FloatArray:
    return np.stack([np.sin(2.0 * time), 0.6 * np.sin(3.1 * time + 1.0)], axis=1)


def polls(spread: float) -> tuple[IntArray, IntArray]:
    """Return the stamps of the polls [ns], and the number of the value that each of them takes."""
    random = np.random.default_rng(3)
    time = np.cumsum(PERIOD * np.maximum(1.02 + spread * random.standard_normal(N), 0.5))
    return np.rint(1e9 * time).astype(np.int64), np.floor(time / PERIOD).astype(np.int64)


def log_of(spread: float = 0.25) -> tuple[Log, IntArray]:
    stamp, number = polls(spread)
    position = np.round(motion(number * PERIOD), 6)
    states = JointSeries(stamp, ("motor_1", "motor_2"), position=position, effort=np.cos(position))
    return Log(joint_states=states, provenance={"import": {}}), number


def test_periods_between_values_are_found() -> None:
    log, number = log_of()
    states = log.joint_states
    assert states.position is not None
    source = polled_source(states.stamp, states.position)
    assert source is not None
    assert source.period == pytest.approx(PERIOD, rel=1e-3)
    assert np.mean(source.steps == np.diff(number)) > 0.99
    assert source.repeated == pytest.approx(np.mean(np.diff(number) == 0), abs=0.01)
    assert source.missed == pytest.approx(1 - len(np.unique(number)) / (number[-1] - number[0] + 1), abs=0.01)


def test_the_log_becomes_even_with_positions_at_their_instants() -> None:
    log, number = log_of()
    warnings: list[str] = []
    states = recovered(log, warnings).joint_states
    assert len(warnings) == 1
    assert np.ptp(np.diff(states.stamp)) < 1e-3 * 1e9 * PERIOD
    assert states.position is not None
    assert states.effort is not None
    assert states.effort.shape == states.position.shape
    true = motion((number[0] + np.arange(len(states.stamp))) * PERIOD)
    assert np.abs(states.position - true).max() < 5 * PERIOD  # one value at a turn may be a period off
    assert np.median(np.abs(states.position - true)) < 1e-6


def test_jitter_of_stamps_beside_a_few_lost_rows_is_no_poll() -> None:
    """The fastest motion is bent: by means over it the period seems 3 % too long, so that stamps seemed off."""
    random = np.random.default_rng(5)
    time = 0.01 * np.arange(4000)
    position = np.round(0.8 * np.sin(2 * np.pi * 0.9 * time), 5)[:, None]
    stamp = np.rint(1e9 * (time + 1.0 + 3e-4 * random.standard_normal(4000))).astype(np.int64)
    kept = np.ones(4000, dtype=bool)
    kept[random.choice(4000, 40, replace=False)] = False
    assert polled_source(stamp[kept], position[kept]) is None


@pytest.mark.parametrize("times", [2, 3, 5, 7, 9, 12, 15, 20])
def test_a_recorder_that_is_faster_by_a_whole_number_holds_each_value(times: int) -> None:
    """Also beside a standstill, where the values of the source are the same."""
    at_rest = (np.arange(1500) > 700) & (np.arange(1500) < 760)
    once = np.round(motion(0.01 * np.cumsum(~at_rest)), 6)
    held = np.repeat(once, times, axis=0)
    stamp = np.rint(np.arange(len(held)) * 1e7 / times).astype(np.int64)
    source = polled_source(stamp, held)
    assert source is not None
    assert source.period == pytest.approx(0.01, rel=1e-6)
    assert source.missed == 0.0
    states = JointSeries(stamp, ("motor_1", "motor_2"), position=held)
    assert np.array_equal(source.evened(states).position, once)


def test_values_held_in_a_motion_that_is_fast_for_them_are_told_by_their_stamps() -> None:
    """At last 13 values in a turn of the motion: too few for a speed from several of them."""
    time = 0.015 * np.arange(800)
    once = np.round(0.2 * np.sin(2 * np.pi * (0.1 + 0.2 * time) * time), 4)[:, None]
    held = np.repeat(once, 15, axis=0)
    stamp = 1_000_000 * np.arange(len(held))
    source = polled_source(stamp, held)
    assert source is not None
    assert source.period == pytest.approx(0.015, rel=1e-6)
    states = JointSeries(stamp, ("motor_1",), position=held)
    np.testing.assert_allclose(source.evened(states).position, once, atol=1e-12)


def test_torques_taken_while_a_position_is_held_become_their_mean() -> None:
    held = np.repeat(np.round(motion(0.01 * np.arange(1500)), 6), 5, axis=0)
    effort = np.arange(len(held), dtype=float)[:, None] * [1.0, -2.0]
    stamp = 2_000_000 * np.arange(len(held))
    source = polled_source(stamp, held)
    assert source is not None
    evened = source.evened(JointSeries(stamp, ("motor_1", "motor_2"), position=held, effort=effort))
    np.testing.assert_allclose(evened.effort, effort.reshape(-1, 5, 2).mean(axis=1))


def test_steps_of_a_coarse_encoder_are_no_held_values() -> None:
    """Slow motion, several rows within one step, and any number of them."""
    time = PERIOD * np.arange(N)
    coarse = np.round(0.3 * np.sin(2.0 * time) / 2e-3) * 2e-3
    assert polled_source(np.rint(1e9 * time).astype(np.int64), coarse[:, None]) is None


def test_a_lost_value_is_one_that_was_missed() -> None:
    log, _ = log_of()
    states = log.joint_states
    position = np.array(states.position)
    position[4000, 1] = np.nan
    warnings: list[str] = []
    evened = recovered(replace(log, joint_states=replace(states, position=position)), warnings).joint_states
    assert len(warnings) == 1
    assert len(evened.stamp) == pytest.approx(len(recovered(log, []).joint_states.stamp), abs=2)
    assert np.isfinite(evened.position).all()


def test_commands_taken_together_are_evened_alike() -> None:
    log, _ = log_of()
    states = log.joint_states
    commands = JointSeries(states.stamp, states.names, effort=states.effort)
    both = recovered(Log(joint_states=states, joint_commands=commands, provenance=log.provenance), [])
    assert both.joint_commands is not None
    assert both.joint_commands.effort is not None
    assert both.joint_states.effort is not None
    np.testing.assert_array_equal(both.joint_commands.effort, both.joint_states.effort)


def test_other_logs_stay_as_they_are() -> None:
    time = PERIOD * np.arange(N)
    stamp = np.rint(1e9 * time).astype(np.int64)
    jittering = time + 0.1 * PERIOD * np.random.default_rng(4).standard_normal(N)
    assert polled_source(stamp, motion(time)) is None  # even
    assert polled_source(stamp, motion(jittering)) is None  # jitter of the clock is no whole period
    kept = np.sort(np.random.default_rng(5).choice(N, 9 * N // 10, replace=False))
    assert polled_source(stamp[kept], motion(time[kept])) is None  # lost messages: the stamps say so
    assert polled_source(stamp, np.zeros((N, 2))) is None  # standing still


def test_a_pause_between_two_runs_is_no_loss_of_a_recorder() -> None:
    """Each run ends and begins at rest, somewhere else."""
    time = PERIOD * np.arange(3000)
    run = 0.5 * (1 - np.cos(2 * np.pi * time / time[-1]))[:, None] * [1.0, -0.7] + 1e-7 * np.sin(1e3 * time)[:, None]
    position = np.concatenate([run, run + 0.4])
    stamp = np.rint(1e9 * np.concatenate([time, time[-1] + 0.5 + time])).astype(np.int64)
    assert polled_source(stamp, position) is None
