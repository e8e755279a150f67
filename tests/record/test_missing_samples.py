"""Runs, bridges and long holes."""

from __future__ import annotations

import numpy as np

from flexros.record.missing_samples import (
    MOST_BRIDGED,
    bridged,
    bridged_motion,
    long_holes,
    longest_run,
    pauses,
    runs,
)


def test_runs_have_begin_and_length() -> None:
    begin, length = runs(np.array([True, False, False, True, True, True]))
    assert (begin.tolist(), length.tolist()) == ([0, 3], [1, 3])
    assert longest_run(np.array([True, False, True, True])) == 2
    assert longest_run(np.zeros(3, dtype=bool)) == 0


def test_holes_are_long_beyond_the_limit() -> None:
    valid = np.ones(40, dtype=bool)
    valid[5 : 5 + MOST_BRIDGED] = False
    valid[20 : 21 + MOST_BRIDGED] = False
    np.testing.assert_array_equal(np.flatnonzero(long_holes(valid)), np.arange(20, 21 + MOST_BRIDGED))


def test_pauses_lie_between_long_stretches() -> None:
    valid = np.ones(400, dtype=bool)
    valid[100:200] = False  # a pause
    valid[300:320] = False  # a loss: 25 samples follow
    valid[345:360] = False
    valid[390:] = False  # the end
    np.testing.assert_array_equal(np.flatnonzero(pauses(valid)), np.arange(100, 200))
    assert not pauses(np.ones(10, dtype=bool)).any()


def test_long_holes_are_bridged_by_straight_lines() -> None:
    time = 1e-3 * np.arange(4000)
    position = np.column_stack([2.0 * time, 1.0 - time])
    valid = np.ones(len(time), dtype=bool)
    valid[100:150] = False
    holed = np.where(valid[:, None], position, 99.0)
    np.testing.assert_allclose(bridged(holed, valid), position, atol=1e-12)
    assert bridged(position, np.ones(len(time), dtype=bool)) is position


def test_short_holes_are_bridged_without_corners() -> None:
    time = 1e-3 * np.arange(400)
    position = np.sin(20 * time)[:, None]
    valid = np.random.default_rng(1).random(len(time)) > 0.1
    valid[[0, -1]] = True
    filled = bridged_motion(np.where(valid[:, None], position, 99.0), valid)
    np.testing.assert_array_equal(filled[valid], position[valid])
    np.testing.assert_allclose(filled, position, atol=1e-6)


def test_samples_missing_at_the_ends_are_held() -> None:
    values, valid = np.arange(9.0)[:, None], np.array([0, 0, 1, 1, 1, 1, 1, 1, 0], dtype=bool)
    np.testing.assert_array_equal(bridged_motion(values, valid)[[0, 1, 8], 0], [2.0, 2.0, 7.0])
