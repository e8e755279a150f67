"""Runs, bridges and long holes."""

from __future__ import annotations

import numpy as np

from flexros.record.missing_samples import MOST_BRIDGED, bridged, long_holes, longest_run, runs


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


def test_holes_are_bridged_by_straight_lines() -> None:
    time = 1e-3 * np.arange(4000)
    position = np.column_stack([2.0 * time, 1.0 - time])
    valid = np.ones(len(time), dtype=bool)
    valid[100:150] = False
    holed = np.where(valid[:, None], position, 99.0)
    np.testing.assert_allclose(bridged(holed, valid), position, atol=1e-12)
    assert bridged(position, np.ones(len(time), dtype=bool)) is position
