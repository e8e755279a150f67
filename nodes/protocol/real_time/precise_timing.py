"""Thread priority and wake-up latency of the real-time loop, as far as the operating system permits."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
import threading
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

PRIORITY = 10
"""Real-time priority of the loop, 1 to 99: above all ordinary processes, below the threads of the kernel."""

PACING_PRIORITY = PRIORITY + 2
"""Real-time priority of the thread that paces the loop, chosen: it interrupts the others of the loop when its
time has come."""

_PR_SET_TIMERSLACK = 29
_SWITCH_INTERVAL = 1e-4
_MIDDLEWARE = "dds."
_FLOW_CONTROLLER = "dds.asyn"


def take_priority(priority: int = PRIORITY, threads: Iterable[int] = (0,)) -> bool:
    """Give threads real-time priority (SCHED_RR), if the system permits it.

    The scheduler is round-robin, so that a thread that busy-waits for another one of them does not block it for ever.
    Threads started later by these have ordinary priority: compression of the log must not delay the loop.

    Args:
        priority: Real-time priority, 1 to 99.
        threads: Thread identifiers; 0 is the present thread.

    Returns:
        Whether the system permitted it: root, or a user with a limit of `ulimit -r` above the priority.
    """
    if not hasattr(os, "sched_setscheduler"):
        return False
    policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK
    try:
        for thread in threads:
            with suppress(ProcessLookupError):  # the thread has ended meanwhile
                os.sched_setscheduler(thread, policy, os.sched_param(priority))
    except OSError:
        return False
    return True


@contextmanager
def priority_in_block() -> Iterator[bool]:
    """Give the present thread real-time priority within the block; yield whether the system permitted it.

    The previous policy and priority are restored afterwards.
    """
    if not hasattr(os, "sched_setscheduler"):
        yield False
        return
    policy, parameter = os.sched_getscheduler(0), os.sched_getparam(0)
    prioritised = take_priority(PACING_PRIORITY)
    try:
        yield prioritised
    finally:
        if prioritised:
            _restore(policy, parameter)


def _restore(policy: int, parameter: os.sched_param) -> None:
    try:
        os.sched_setscheduler(0, policy, parameter)
    except PermissionError:  # only root may clear SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameter)


def threads_of_loop() -> list[int]:
    """List the threads of this process that carry messages; on systems other than Linux only the present one.

    These are all threads but the flow controller of Fast DDS, which repeats lost messages: it polls a lock without
    sleeping, so with priority it would starve the holder of the lock and everything else on its core.
    """
    tasks = Path("/proc/self/task")
    if not tasks.is_dir():
        return [0]
    return sorted(int(task.name) for task in tasks.iterdir() if not _name(task).startswith(_FLOW_CONTROLLER))


def middleware_threads() -> list[int]:
    """List the threads of Fast DDS in this process, but for the flow controller; empty on other systems."""
    tasks = Path("/proc/self/task")
    if not tasks.is_dir():
        return []
    return [thread for thread in threads_of_loop() if _name(tasks / str(thread)).startswith(_MIDDLEWARE)]


def late_threads() -> list[int]:
    """List the threads of C++ libraries that were started without priority after the loop had got its own.

    EventsExecutor starts one with its first timer. It holds the lock of the queue of events, so that at ordinary
    priority it would let the loop wait for other programs. Threads of Python are left alone: they compress the log.
    """
    if not Path("/proc/self/task").is_dir():
        return []
    of_python = {thread.native_id for thread in threading.enumerate()}
    ordinary = [thread for thread in threads_of_loop() if thread not in of_python]
    return [thread for thread in ordinary if _policy(thread) == os.SCHED_OTHER]


def _policy(thread: int) -> int | None:
    try:
        return os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK
    except OSError:  # the thread has ended meanwhile
        return None


def _name(task: Path) -> str:
    try:
        return (task / "comm").read_text(encoding="ascii", errors="replace")
    except OSError:  # the thread has ended meanwhile
        return ""


@contextmanager
def precise_timing() -> Iterator[bool]:
    """Reduce the wake-up latency of this thread within the block; yield whether it got real-time priority.

    Linux adds a timer slack of 50 us to every sleep, which alone is the limit of a late cycle; garbage collection and
    the switch interval of Python threads add to it. Within the block the slack and the switch interval are shortened,
    garbage collection is off, and the thread has real-time priority where permitted.
    """
    slack = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
    interval = sys.getswitchinterval()
    was_enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    sys.setswitchinterval(_SWITCH_INTERVAL)
    if slack:
        slack(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    try:
        with priority_in_block() as prioritised:
            yield prioritised
    finally:
        if slack:
            slack(_PR_SET_TIMERSLACK, 0, 0, 0, 0)  # 0 restores the default
        sys.setswitchinterval(interval)
        if was_enabled:
            gc.enable()
        gc.unfreeze()
