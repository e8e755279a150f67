"""Wake-up of waiting threads when the system clock is set."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from flexros_nodes.protocol.process import clock_steps
from flexros_nodes.protocol.process.clock_steps import waking_at_clock_steps
from tests.soak.stepped_clock import clock_may_be_set


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def test_a_clock_that_is_set_wakes() -> None:
    """The clock is set to what it shows."""
    if not clock_may_be_set():
        pytest.skip("this user may not set the clock")
    woken = threading.Semaphore(0)
    with waking_at_clock_steps(woken.release) as told:
        assert told
        for _ in range(3):
            assert clock_may_be_set()
            assert woken.acquire(timeout=10.0)


def test_every_news_of_the_timer_wakes(monkeypatch: pytest.MonkeyPatch) -> None:
    timer, news = os.pipe()
    monkeypatch.setattr(clock_steps, "clock_timer", lambda: timer)
    woken = threading.Semaphore(0)
    with waking_at_clock_steps(woken.release):
        for _ in range(3):
            os.write(news, b"12345678")
            assert woken.acquire(timeout=10.0)
        assert not woken.acquire(timeout=0.05)
    os.close(news)


def test_nothing_stays_behind() -> None:
    before = open_files(), threading.active_count()
    with waking_at_clock_steps(lambda: None):
        assert threading.active_count() == before[1] + 1
    assert (open_files(), threading.active_count()) == before


def test_system_without_clock_timer_is_not_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock_steps, "clock_timer", lambda: None)
    with waking_at_clock_steps(lambda: None) as told:
        assert not told


@pytest.mark.parametrize("descriptor", [None, -1])
def test_without_timers_there_is_none(monkeypatch: pytest.MonkeyPatch, descriptor: int | None) -> None:
    class Library:
        if descriptor is not None:

            def timerfd_create(self, *_: int) -> int:
                return descriptor or -1

    monkeypatch.setattr(clock_steps.ctypes, "CDLL", lambda _: Library())
    assert clock_steps.clock_timer() is None


def test_a_timer_that_cannot_be_armed_is_closed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    descriptor = os.open(tmp_path, os.O_RDONLY)

    class Library:
        def timerfd_create(self, *_: int) -> int:
            return descriptor

        def timerfd_settime(self, *_: object) -> int:
            return -1

    monkeypatch.setattr(clock_steps.ctypes, "CDLL", lambda _: Library())
    assert clock_steps.clock_timer() is None
    with pytest.raises(OSError, match="Bad file"):
        os.close(descriptor)
