"""Stamps against the plan."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.checks.record_timing import check_equal_rates, check_no_gap, sample_numbers
from flexros.logs.stamps import START_NS, stamps_ns

T = 1e-3


def numbers_of(stamp: np.ndarray, highest: float = 60.0, warnings: list[str] | None = None) -> np.ndarray:
    return sample_numbers(stamp, START_NS, T, "joint_states", highest, [] if warnings is None else warnings)


def test_stamps_of_flexros_are_numbered_without_a_warning() -> None:
    warnings: list[str] = []
    np.testing.assert_array_equal(numbers_of(stamps_ns(500, T), warnings=warnings), np.arange(500))
    assert warnings == []


def test_lower_rate_than_the_plan_is_aliasing_where_lines_lie_above_its_nyquist_frequency() -> None:
    stamp = stamps_ns(50, 10 * T)
    with pytest.raises(InputError, match="aliasing: joint_states is sampled at 100 Hz, so what is excited up to 60 Hz"):
        numbers_of(stamp)
    with pytest.raises(
        InputError, match="joint_states is sampled at 100 Hz, the plan says 1000 Hz; record every sample"
    ):
        numbers_of(stamp, highest=20.0)


def test_repeated_stamps_are_counted() -> None:
    stamp = np.sort(np.append(stamps_ns(100, T), stamps_ns(100, T)[40:42] + 50_000))
    with pytest.raises(InputError, match=r"joint_states has 2 repeated stamps, the first at 0\.0400 s"):
        numbers_of(stamp)


def test_offset_of_a_topic_is_refused() -> None:
    with pytest.raises(InputError, match=r"joint_states is stamped \+0\.3 ms off the sampling instant"):
        numbers_of(stamps_ns(100, T) + 300_000)


def test_jitter_is_warned_of() -> None:
    warnings: list[str] = []
    noise = np.random.default_rng(0).normal(0, 2e4, 200).astype(np.int64)
    np.testing.assert_array_equal(numbers_of(stamps_ns(200, T) + noise, warnings=warnings), np.arange(200))
    assert len(warnings) == 1
    assert "the stamps of joint_states jitter by" in warnings[0]


def test_single_message_is_too_short() -> None:
    with pytest.raises(InputError, match="too short a log: joint_states has 1 messages"):
        numbers_of(stamps_ns(1, T))


def test_unequal_rates_are_refused() -> None:
    check_equal_rates(stamps_ns(100, T), stamps_ns(90, T))
    with pytest.raises(
        InputError, match="unequal rates: joint_states is sampled at 1000 Hz and joint_commands at 500 Hz"
    ):
        check_equal_rates(stamps_ns(100, T), stamps_ns(50, 2 * T))


def test_gap_names_location_and_count() -> None:
    numbers = np.delete(np.arange(100), [20, 21, 40])
    check_no_gap(numbers, 50, 100, T, "block 1")
    with pytest.raises(
        InputError, match=r"gap: 3 samples of joint_states are missing in block 1, the first at 0\.0200 s"
    ):
        check_no_gap(numbers, 10, 60, T, "block 1")
    with pytest.raises(InputError, match=r"gap: 1 samples .* the first at 0\.0400 s"):
        check_no_gap(numbers, 40, 60, T, "block 1")


def test_log_that_ends_early_or_begins_late_misses_periods() -> None:
    with pytest.raises(
        InputError, match=r"too short a log: it ends at 0\.099 s, block 2 lasts until 0\.149 s, so periods"
    ):
        check_no_gap(np.arange(100), 50, 150, T, "block 2")
    with pytest.raises(InputError, match=r"the log begins at 0\.030 s, block 1 at 0\.010 s, so periods are missing"):
        check_no_gap(np.arange(30, 200), 10, 150, T, "block 1")
