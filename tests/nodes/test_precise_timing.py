"""Thread settings of a real-time run: taken, and given back."""

from __future__ import annotations

import gc
import os
import sys
import threading

import pytest

from flexros_nodes.precise_timing import PRIORITY, own_threads, precise_timing, take_priority


def policy() -> int:
    return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK


def test_settings_come_back() -> None:
    interval = sys.getswitchinterval()
    assert gc.isenabled()
    with precise_timing():
        assert not gc.isenabled()
        assert sys.getswitchinterval() < interval
    assert gc.isenabled()
    assert sys.getswitchinterval() == interval
    assert policy() == os.SCHED_OTHER


def test_priority_is_told_as_it_is() -> None:
    with precise_timing() as prioritised:
        assert prioritised == (policy() == os.SCHED_FIFO)


def test_threads_begun_with_priority_are_ordinary_ones() -> None:
    policies: list[int] = []
    with precise_timing():
        thread = threading.Thread(target=lambda: policies.append(policy()))
        thread.start()
        thread.join()
    assert policies == [os.SCHED_OTHER]


def test_priority_found_before_comes_back() -> None:
    found: list[tuple[int, int]] = []

    def work() -> None:  # in a thread of its own, which ends with its priority
        if take_priority(7):
            with precise_timing():
                found.append((policy(), os.sched_getparam(0).sched_priority))
            found.append((policy(), os.sched_getparam(0).sched_priority))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found in ([], [(os.SCHED_FIFO, PRIORITY), (os.SCHED_FIFO, 7)])


def test_thread_that_has_ended_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    set_for: list[int] = []

    def scheduler(thread: int, *_: object) -> None:
        if thread == 1:
            raise ProcessLookupError
        set_for.append(thread)

    monkeypatch.setattr(os, "sched_setscheduler", scheduler)
    assert take_priority(5, (1, 2))
    assert set_for == [2]


def test_threads_of_the_process_are_listed() -> None:
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        assert thread.native_id in own_threads()
    finally:
        done.set()
        thread.join()


def test_refused_priority_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert not take_priority()


def test_system_without_real_time_priorities_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    assert not take_priority()
