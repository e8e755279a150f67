"""Percentiles of times in bounded memory."""

from __future__ import annotations

import numpy as np
import pytest

from flexros_nodes.protocol.real_time.period_histogram import PeriodHistogram

T = 5e-4
RNG = np.random.default_rng(8)


def test_percentiles_are_right_to_a_bin() -> None:
    times = T * (1.0 + 0.2 * RNG.standard_normal(5000))
    histogram = PeriodHistogram(T)
    for time in times:
        histogram.add(float(time))
    for share in (1.0, 50.0, 99.0):
        assert histogram.percentile(share) == pytest.approx(np.percentile(times, share), abs=1.5e-6)
    assert histogram.longest == times.max()


def test_percentiles_of_long_times_are_not_their_maximum() -> None:
    times = T * 10.0 ** RNG.uniform(0.5, 4.0, 5000)
    histogram = PeriodHistogram(T)
    for time in times:
        histogram.add(float(time))
    for share in (1.0, 50.0, 99.0):
        assert histogram.percentile(share) == pytest.approx(np.percentile(times, share), rel=0.015)
    assert histogram.percentile(99.0) < 0.95 * times.max() == 0.95 * histogram.longest


def test_times_beyond_the_bins_keep_their_maximum() -> None:
    histogram = PeriodHistogram(T)
    for time in (T, T, 7000.0, 9000.0):
        histogram.add(time)
    assert histogram.percentile(99.0) == 9000.0
    assert histogram.percentile(50.0) == pytest.approx(T)


def test_merging_counts_both_and_leaves_them_alone() -> None:
    one, other = PeriodHistogram(T), PeriodHistogram(T)
    one.add(1e-4)
    other.add(3e-4)
    other.add(3e-4)
    both = one.merged(other)
    assert (both.count, both.longest, one.count, other.count) == (3, 3e-4, 1, 2)
    assert both.percentile(20.0) == pytest.approx(1e-4)
    assert both.percentile(80.0) == pytest.approx(3e-4)
