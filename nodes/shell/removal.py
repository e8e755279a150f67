"""Removal of nodes from the graph, which Fast DDS may never end.

While a participant is removed, a callback of its discovery can wait for the lock that the removal holds: this happens
when a partner leaves at that moment. Fast DDS 2.14 as built for the wheels then spins for ever, in
`DomainParticipant::set_listener`, and holds the lock of Python (compare eProsima/Fast-DDS issue 6513).
"""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from time import monotonic, sleep
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


def limit_time(timeout: float) -> None:
    """Let SIGALRM end this process after a time [s], also while the lock of Python is held."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, timeout)


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
    limit_time(REMOVAL_TIMEOUT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, delay, interval)
        signal.signal(signal.SIGALRM, signal.SIG_DFL if handler is None else handler)
