"""Growth of memory over time: a leak is reported, constant memory is flat."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import psutil
import pytest

from tests.soak.watching import Sample, Watched, growth, growth_counts, watch

RATE = 2000.0


def samples(bytes_per_sample: float, noise: float = 4096.0, handles: int = 20, last_handles: int = 20) -> list[Sample]:
    """Make samples of half an hour, every 3 s."""
    random = np.random.default_rng(1)
    times = np.arange(0.0, 1800.0, 3.0)
    memory = 1e8 + bytes_per_sample * RATE * times + noise * random.normal(size=len(times))
    n = len(times)
    return [
        (float(t), float(m), handles if i < n // 2 else last_handles, 15) for i, (t, m) in enumerate(zip(times, memory))
    ]


@pytest.mark.parametrize("leak", [0.0, 0.5, 16.0])
def test_slope_is_found_with_its_interval(leak: float) -> None:
    seen = growth(samples(leak), RATE)
    assert abs(seen.slope - leak) < 2.0 * seen.half_width
    assert seen.half_width < 0.01


def test_one_object_of_python_in_each_sample_is_no_longer_flat() -> None:
    assert growth(samples(0.0), RATE).is_flat
    assert not growth(samples(16.0), RATE).is_flat


def test_one_file_that_stays_open_is_no_longer_flat() -> None:
    assert not growth(samples(0.0, last_handles=21), RATE).is_flat


def test_growth_that_may_be_large_is_not_called_flat() -> None:
    assert not growth(samples(0.0, noise=1e8), RATE).is_flat


def test_beginning_and_end_do_not_count() -> None:
    rows = samples(0.0)
    rows[0] = (0.0, 9e9, 99, 99)
    rows[-1] = (rows[-1][0], 9e9, 99, 99)
    assert growth(rows, RATE).is_flat


def test_processes_are_watched_until_it_is_over() -> None:
    looks = iter([False, False, True])
    seen = watch(os.getpid(), lambda: next(looks), 0.01)
    assert len(seen["run"].samples) == 2
    assert all(memory > 1e6 and handles > 0 for _, memory, handles, _ in seen["run"].samples)


def test_files_that_come_and_go_are_named(tmp_path: Path) -> None:
    process, seen = psutil.Process(), Watched()
    seen.look(process, 0.0)
    with (tmp_path / "log").open("w"):
        seen.look(process, 1.0)
        seen.look(process, 2.0)
    seen.look(process, 3.0)
    name = str(tmp_path / "log")
    assert seen.opened == [(1.0, [name], []), (3.0, [], [name])]
    assert [growth_counts(at, 0.0, 30.0) for at in (1.0, 15.0, 29.9)] == [False, True, False]
