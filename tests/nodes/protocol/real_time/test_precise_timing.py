"""Thread settings of a real-time run, and their restoration."""

from __future__ import annotations

import gc
import os
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from flexros_nodes.protocol.real_time.precise_timing import (
    PACING_PRIORITY,
    precise_timing,
    take_priority,
    threads_of_loop,
)


def policy() -> int:
    return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK


@pytest.mark.slow
def test_settings_come_back() -> None:
    interval = sys.getswitchinterval()
    assert gc.isenabled()
    with precise_timing():
        assert not gc.isenabled()
        assert sys.getswitchinterval() < interval
    assert gc.isenabled()
    assert sys.getswitchinterval() == interval
    assert policy() == os.SCHED_OTHER


@pytest.mark.slow
def test_priority_is_reported() -> None:
    with precise_timing() as prioritised:
        assert prioritised == (policy() == os.SCHED_RR)


@pytest.mark.slow
def test_threads_begun_with_priority_are_ordinary_ones() -> None:
    policies: list[int] = []
    with precise_timing():
        thread = threading.Thread(target=lambda: policies.append(policy()))
        thread.start()
        thread.join()
    assert policies == [os.SCHED_OTHER]


def test_previous_priority_is_restored() -> None:
    found: list[tuple[int, int]] = []

    def work() -> None:  # in a thread of its own, which ends with its priority
        if take_priority(7):
            with precise_timing():
                found.append((policy(), os.sched_getparam(0).sched_priority))
            found.append((policy(), os.sched_getparam(0).sched_priority))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found in ([], [(os.SCHED_RR, PACING_PRIORITY), (os.SCHED_RR, 7)])


def test_ended_thread_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
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
        assert thread.native_id in threads_of_loop()
    finally:
        done.set()
        thread.join()


@pytest.mark.skipif(sys.platform != "linux", reason="names of threads are read as Linux tells them")
def test_thread_that_tries_locks_without_sleeping_stays_an_ordinary_one() -> None:
    done, named = threading.Event(), threading.Event()

    def work() -> None:
        Path(f"/proc/self/task/{threading.get_native_id()}/comm").write_text("dds.asyn.0.0", encoding="ascii")
        named.set()
        done.wait()

    thread = threading.Thread(target=work)
    thread.start()
    try:
        assert named.wait(10.0)
        assert thread.native_id not in threads_of_loop()
    finally:
        done.set()
        thread.join()


@pytest.mark.skipif(sys.platform != "linux", reason="names of threads are read as Linux tells them")
def test_fast_dds_names_that_thread_so(bench: Any) -> None:
    node = pytest.importorskip("rclpy.node", reason="needs ROS 2").Node("mine", context=bench.context)
    bench.hold(node)
    names = [(task / "comm").read_text(encoding="ascii") for task in Path("/proc/self/task").iterdir()]
    assert any(name.startswith("dds.asyn") for name in names), names


def test_denied_priority_is_not_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert not take_priority()


def test_system_without_real_time_priorities_is_not_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    assert not take_priority()
