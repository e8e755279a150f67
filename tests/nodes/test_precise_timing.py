"""Thread settings of a real-time run: taken, and given back."""

from __future__ import annotations

import gc
import os
import sys
import threading

import pytest

from flexros_nodes.precise_timing import own_threads, precise_timing, take_priority


def test_settings_come_back() -> None:
    interval = sys.getswitchinterval()
    assert gc.isenabled()
    with precise_timing():
        assert not gc.isenabled()
        assert sys.getswitchinterval() < interval
    assert gc.isenabled()
    assert sys.getswitchinterval() == interval
    assert os.sched_getscheduler(0) == os.SCHED_OTHER


def test_priority_is_told_as_it_is() -> None:
    with precise_timing() as prioritised:
        assert prioritised == (os.sched_getscheduler(0) == os.SCHED_FIFO)


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
