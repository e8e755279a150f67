from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.loop_timing import loop_timing, topic_timing
from flexros.logs.time_series import JointSeries, Log

PERIOD = 500_000


def grid(n, period=PERIOD):
    return 1_000_000_000 + np.arange(n, dtype=np.int64) * period


def series(stamp):
    return JointSeries(stamp, ("motor_1",), position=np.zeros((len(stamp), 1)))


def test_an_exact_grid_is_exact():
    timing = topic_timing("joint_states", grid(1000), 1_000_000_000)
    assert timing.exact
    assert timing.period == pytest.approx(5e-4, abs=1e-15)
    assert timing.jitter_max == 0.0
    assert timing.missed == 0


def test_rounding_to_nanoseconds_is_no_jitter():
    stamp = 1_000_000_000 + np.rint(np.arange(1000) / 3000 * 1e9).astype(np.int64)
    assert topic_timing("joint_states", stamp, 1_000_000_000).exact


def test_known_jitter_is_found():
    rng = np.random.default_rng(5)
    step = PERIOD + np.rint(rng.normal(0.0, 20e-6, 20_000) * 1e9).astype(np.int64)
    timing = topic_timing("joint_states", np.cumsum(step), 0)
    assert not timing.exact
    assert timing.mean_period == pytest.approx(5e-4, rel=1e-3)
    assert timing.jitter_std == pytest.approx(20e-6, rel=0.02)
    assert timing.jitter_p99 == pytest.approx(2.576 * 20e-6, rel=0.05)
    assert timing.jitter_max == pytest.approx(np.max(np.abs(step[1:] - PERIOD)) * 1e-9, rel=0.01)


def test_gaps_are_named_with_time_and_size_and_are_no_jitter():
    stamp = np.delete(grid(1000), [400, 700, 701, 702])
    timing = topic_timing("joint_commands", stamp, 1_000_000_000)
    assert timing.missed == 4
    assert [(gap.time, gap.missing) for gap in timing.gaps] == [(pytest.approx(0.1995), 1), (pytest.approx(0.3495), 3)]
    assert timing.jitter_max == 0.0
    assert not timing.exact


def test_repeated_and_late_messages_are_counted():
    stamp = grid(100)
    stamp = np.concatenate([stamp[:50], stamp[49:50], stamp[51:52], stamp[50:51], stamp[52:]])
    timing = topic_timing("joint_states", stamp, 1_000_000_000)
    assert timing.duplicates == 1
    assert timing.out_of_order == 1
    assert timing.missed == 0


def test_one_message_has_no_period():
    timing = topic_timing("joint_states", grid(1), 1_000_000_000)
    assert np.isnan(timing.period)
    assert timing.as_dict()["period_s"] is None


def test_commands_are_matched_to_states_by_stamp():
    states = grid(100)
    commands = np.delete(states, [10, 11])
    commands[50] += 7
    timing = loop_timing(Log(series(states), series(commands)))
    assert timing.unanswered == 3
    assert timing.unasked == 1
    assert timing.answered == pytest.approx(0.97)
    assert not timing.exact


def test_a_last_measurement_without_command_is_no_loss():
    timing = loop_timing(Log(series(grid(100)), series(grid(99))))
    assert timing.unanswered == 0
    assert timing.exact


def test_a_late_start_of_a_topic_is_reported():
    timing = loop_timing(Log(series(grid(100)), series(grid(100)[20:])))
    commands = timing.topic("joint_commands")
    assert commands is not None
    assert commands.start == pytest.approx(0.01)
    assert timing.unanswered == 20


def test_absent_topics_are_left_out():
    timing = loop_timing(Log(series(grid(10))))
    assert [topic.topic for topic in timing.topics] == ["joint_states"]
