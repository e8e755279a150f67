"""Removal of nodes from the graph, which Fast DDS may never end.

While a participant is removed, a callback of its discovery can wait for the lock that the removal holds: this happens
when a partner leaves at that moment. Fast DDS 2.14 as built for the wheels then spins for ever, in
`DomainParticipant::set_listener`, and holds the lock of Python (compare eProsima/Fast-DDS issue 6513).
"""

from __future__ import annotations

import ctypes
import signal
import threading
from contextlib import contextmanager
from time import CLOCK_MONOTONIC, monotonic, sleep
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rclpy.node import Node

REMOVAL_TIMEOUT = 10.0
"""Longest time for the middleware to remove the nodes of a process [s], chosen: it takes about 0.1 s."""

DEPARTURE_TIMEOUT = 0.5
"""Longest wait for partners to leave the graph [s], chosen: a killed one remains for long."""

DEPARTURE_PERIOD = 0.05
"""Period at which the graph is looked at, and time for what a partner sent last to be processed [s], chosen."""


def await_departures(node: Node, partners: Iterable[str]) -> None:
    """Wait until nodes whose processes have ended have left the graph, before the middleware is removed.

    Args:
        node: Any node of this process.
        partners: Names of the nodes that have ended.
    """
    left = set(partners)
    deadline = monotonic() + DEPARTURE_TIMEOUT
    while left and monotonic() < deadline:
        sleep(DEPARTURE_PERIOD)
        left &= set(node.get_node_names())


class _EndOfTimer(ctypes.Structure):
    """What happens at the end of a timer of POSIX: `struct sigevent`, which is 64 bytes long on Linux."""

    _fields_ = (
        ("argument", ctypes.c_ssize_t),
        ("signal", ctypes.c_int),
        ("kind", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("unused", ctypes.c_char * 32),
    )


class _TimerTimes(ctypes.Structure):
    """Period of a timer of POSIX, none here, and time to its end: `struct itimerspec`."""

    _fields_ = tuple((name, ctypes.c_long) for name in ("period", "period_nanoseconds", "seconds", "nanoseconds"))


CALLED_IN_A_THREAD = 2
"""Kind of an end of a timer: a thread of the system calls a function (`SIGEV_THREAD`)."""


def end_within(timeout: float, exit_code: int) -> None:
    """End this process after a time with an exit code, also while the lock of Python is held.

    Its work is done by then: a signal would let a launch take it for a node that died.

    Args:
        timeout: Time to the end [s].
        exit_code: What the process ends with.
    """
    system = ctypes.CDLL(None, use_errno=True)
    end = _EndOfTimer(exit_code, 0, CALLED_IN_A_THREAD, ctypes.cast(system._exit, ctypes.c_void_p))
    timer = ctypes.c_void_p()
    times = _TimerTimes(0, 0, int(timeout), int(timeout % 1.0 * 1e9))
    if system.timer_create(CLOCK_MONOTONIC, ctypes.byref(end), ctypes.byref(timer)) or system.timer_settime(
        timer, 0, ctypes.byref(times), None
    ):
        raise OSError(ctypes.get_errno(), "the timer that ends the process cannot be set")


@contextmanager
def limited_removal() -> Iterator[None]:
    """Let SIGALRM end this process if the block, which removes its nodes, does not end: only the system can end it.

    Only the main thread can set a signal.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.getsignal(signal.SIGALRM)
    delay, interval = signal.getitimer(signal.ITIMER_REAL)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, REMOVAL_TIMEOUT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, delay, interval)
        signal.signal(signal.SIGALRM, signal.SIG_DFL if handler is None else handler)
