"""Spinning of nodes: choice of the executor, and the loop that paces a plant by the wall clock."""

from __future__ import annotations

import os
from contextlib import contextmanager
from time import perf_counter, sleep
from typing import TYPE_CHECKING

from rclpy.executors import SingleThreadedExecutor

from flexros_nodes.protocol.process.clock_steps import waking_at_clock_steps
from flexros_nodes.protocol.real_time.bare_loop import BUSY
from flexros_nodes.protocol.real_time.precise_timing import (
    PRIORITY,
    late_threads,
    middleware_threads,
    precise_timing,
    take_priority,
)

try:
    from rclpy.experimental.events_executor import EventsExecutor
except ImportError:  # rclpy before 7.1.4
    EventsExecutor = None

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rclpy.context import Context
    from rclpy.executors import Executor
    from rclpy.task import Future

    from flexros_nodes.protocol.process.interruption import Interruption
    from flexros_nodes.protocol.real_time.schedule import Paced, Schedule
    from flexros_nodes.shell.node_base import FlexrosNode

SLICE = 0.2
"""Longest wait of an executor [s]: unbounded waits of EventsExecutor can hang."""

WATCH_PERIOD = 0.05
"""Period at which the executor checks for signals [s], chosen."""

NAP = 60e-6
"""Longest sleep of the paced loop between two looks for messages [s], chosen: the controller may be in this process."""

MOST_EVENTS = 16
"""Queued events that a late cycle processes to find its command, chosen: all events of one sample."""


def make_executor(context: Context | None) -> Executor:
    """Create the fastest executor available: EventsExecutor, else SingleThreadedExecutor."""
    if EventsExecutor is None:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(executor: Executor, stop: Future, interrupted: Interruption, node: FlexrosNode) -> None:
    """Spin until a future is done.

    Args:
        executor: Executor of the nodes.
        stop: Ends the spinning when it has a result.
        interrupted: Ends the spinning too.
        node: One of the nodes; in real time it is called at the times of its schedule.
    """
    with _watching(interrupted, stop, node), waking_at_clock_steps(executor.wake):
        if (paced := node.paced) is None:
            while not (stop.done() or interrupted()):
                executor.spin_until_future_complete(stop, timeout_sec=SLICE)
            return
        with precise_timing() as paced.prioritised:
            if paced.prioritised:  # else a thread that holds a lock of the middleware waits for ordinary programs
                take_priority(PRIORITY - 1, middleware_threads())
            while not (stop.done() or interrupted()):
                schedule = paced.schedule
                if schedule is None:
                    executor.spin_once(timeout_sec=SLICE)
                else:
                    _await_cycle(executor, paced, schedule)
                    _start_cycle(executor, paced, schedule)


@contextmanager
def _watching(interrupted: Interruption, stop: Future, node: FlexrosNode) -> Iterator[None]:
    """Check for signals in a timer of the executor: a busy executor does not return otherwise."""
    timers_have_priority = False

    def check() -> None:
        nonlocal timers_have_priority
        if not timers_have_priority:  # their thread exists since the first timer, at the latest since this one
            timers_have_priority = True
            _share_priority()
        if interrupted():
            stop.set_result(None)

    timer = node.create_timer(WATCH_PERIOD, check, clock=node.steady_clock)
    try:
        yield
    finally:
        timer.cancel()
        node.destroy_timer(timer)


def _share_priority() -> None:
    """Give the timers of the executor the real-time priority of the present thread, if it has one."""
    if hasattr(os, "sched_getparam") and (priority := os.sched_getparam(0).sched_priority):
        take_priority(min(priority, PRIORITY), late_threads())


def _await_cycle(executor: Executor, paced: Paced, schedule: Schedule) -> None:
    """Process what arrives until the next cycle is about to be due, and sleep meanwhile.

    The executor is not let wait itself: its waits end up to 0.3 ms late, those of the system do not.
    """
    events = 0
    while (remaining := schedule.due - BUSY - perf_counter()) > 0.0:
        executor.spin_once(timeout_sec=0.0)
        events += 1
        if events < MOST_EVENTS // 2 and not paced.answered():
            continue  # of the events that are queued, the measurement for the controller may be the last
        if (remaining := schedule.due - BUSY - perf_counter()) > 0.0:
            sleep(min(remaining, NAP))


def _start_cycle(executor: Executor, paced: Paced, schedule: Schedule) -> None:
    """Start the cycle that is about to be due; until then spin: the controller may be a node of this process."""
    while perf_counter() < schedule.due:
        if not paced.answered():
            executor.spin_once(timeout_sec=0.0)
    for _ in range(MOST_EVENTS):  # after a delay the answer may already be queued
        if paced.answered():
            break
        executor.spin_once(timeout_sec=0.0)
    schedule.started(perf_counter())
    paced.cycle()
