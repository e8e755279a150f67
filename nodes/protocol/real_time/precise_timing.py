"""Making a thread start its work on time, as far as the system lets it; free of ROS."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

PRIORITY = 10
"""Real-time priority of the loop, 1 to 99: above all ordinary processes, below what a system needs for itself."""

_PR_SET_TIMERSLACK = 29
_SWITCH_INTERVAL = 1e-4
_SENDS_AGAIN = "dds.asyn"


def take_priority(priority: int = PRIORITY, threads: Iterable[int] = (0,)) -> bool:
    """Let threads go before all ordinary ones (SCHED_RR), if the system permits it.

    They take turns among themselves, so that one that waits for another without sleeping does not wait for ever.
    Threads that these begin later stand among the ordinary ones: what compresses the log must not delay the loop.

    Args:
        priority: Real-time priority, 1 to 99.
        threads: Numbers of the threads; 0 is the present one.

    Returns:
        Whether the system permitted it: root, or a user with a limit of `ulimit -r` above the priority.
    """
    if not hasattr(os, "sched_setscheduler"):
        return False
    policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK
    try:
        for thread in threads:
            with suppress(ProcessLookupError):  # it has ended meanwhile
                os.sched_setscheduler(thread, policy, os.sched_param(priority))
    except OSError:
        return False
    return True


@contextmanager
def priority_in_block() -> Iterator[bool]:
    """Give the present thread real-time priority while in the block; gives whether the system permitted it.

    Afterwards the thread stands as it was found, also where it had a priority already.
    """
    if not hasattr(os, "sched_setscheduler"):
        yield False
        return
    policy, parameter = os.sched_getscheduler(0), os.sched_getparam(0)
    prioritised = take_priority()
    try:
        yield prioritised
    finally:
        if prioritised:
            _give_back(policy, parameter)


def _give_back(policy: int, parameter: os.sched_param) -> None:
    try:
        os.sched_setscheduler(0, policy, parameter)
    except PermissionError:  # only root may let the threads begun from here on inherit again
        os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameter)


def threads_of_loop() -> list[int]:
    """List the threads of this process that carry messages; on other systems than Linux only the present one.

    Those of the middleware do. But not the one by which Fast DDS sends again (flow controller): it tries a lock without
    sleeping, and with a priority it would keep whoever holds the lock, and all else on its core, from running.
    """
    tasks = Path("/proc/self/task")
    if not tasks.is_dir():
        return [0]
    return sorted(int(task.name) for task in tasks.iterdir() if not _name(task).startswith(_SENDS_AGAIN))


def _name(task: Path) -> str:
    try:
        return (task / "comm").read_text(encoding="ascii", errors="replace")
    except OSError:  # it has ended meanwhile
        return ""


@contextmanager
def precise_timing() -> Iterator[bool]:
    """Let this thread wake up on time while in the block; gives whether it got real-time priority.

    Linux adds a slack of 50 us to every sleep, which alone is the limit of a late cycle; collections of garbage and
    waits for other threads of Python come on top. All of these are put off or shortened, and the thread goes before
    ordinary processes where that is permitted.
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
