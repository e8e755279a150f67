"""Schedule and statistics of real-time runs, with times made up."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from flexros_nodes.protocol.real_time.schedule import Schedule

T = 5e-4


def run_cycles(delays: dict[int, float], n: int = 2000) -> Schedule:
    """Start every cycle when due, some later by a delay [s]."""
    schedule = Schedule(T)
    schedule.begin(10.0)
    for k in range(n):
        schedule.started(schedule.due + delays.get(k, 0.0))
    return schedule


def test_cycles_on_time_have_the_nominal_rate() -> None:
    statistics = run_cycles({}).statistics()
    assert statistics is not None
    assert statistics.cycles == 2000
    assert statistics.rate_hz == pytest.approx(2000.0, abs=1e-6)
    assert statistics.late == 0


def test_small_delays_do_not_add_up() -> None:
    schedule = run_cycles(dict.fromkeys(range(2000), 20e-6))
    assert schedule.due == pytest.approx(10.0 + 2000 * T)


def test_late_cycles_are_counted_beyond_a_tenth_of_the_sample_time() -> None:
    statistics = run_cycles({5: 60e-6, 9: 40e-6, 11: 51e-6}).statistics()
    assert statistics is not None
    assert statistics.late == 2
    assert statistics.late_percent == pytest.approx(0.1)
    assert statistics.lateness_max_us == pytest.approx(60.0, abs=1e-3)


def test_delay_is_caught_up_at_half_the_period_and_the_mean_rate_kept() -> None:
    schedule = Schedule(T)
    schedule.begin(0.0)
    starts = []
    for k in range(100):
        start = schedule.due + (10 * T if k == 20 else 0.0)
        starts.append(start)
        schedule.started(start)
    distances = np.diff(starts)[20:]
    assert distances.min() == pytest.approx(T / 2)
    assert starts[-1] == pytest.approx(99 * T)


def test_no_statistics_before_the_second_cycle() -> None:
    schedule = Schedule(T)
    schedule.begin(0.0)
    schedule.started(0.0)
    assert schedule.statistics() is None


def test_recent_statistics_restart_and_the_total_remains() -> None:
    schedule = run_cycles({3: 70e-6})
    first = schedule.recent_statistics()
    for _ in range(10):
        schedule.started(schedule.due)
    recent, whole = schedule.recent_statistics(), schedule.statistics()
    assert first is not None
    assert recent is not None
    assert whole is not None
    assert (first.cycles, first.late) == (2000, 1)
    assert (recent.cycles, recent.late, recent.lateness_max_us) == (10, 0, pytest.approx(0.0, abs=1e-3))
    assert (whole.cycles, whole.late) == (2010, 1)
    assert whole.rate_hz == pytest.approx(2000.0, abs=1e-6)


def test_memory_does_not_grow_with_the_run() -> None:
    schedule = run_cycles({}, 10)
    size = len(pickle.dumps(schedule))
    for _ in range(5000):
        schedule.started(schedule.due)
    assert len(pickle.dumps(schedule)) < size + 200
