"""Spinning nodes: the choice of the executor, and a loop that paces a plant by the wall clock."""

from __future__ import annotations

import ctypes
import gc
import sys
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING

from rclpy.executors import SingleThreadedExecutor

try:
    from rclpy.experimental.events_executor import EventsExecutor
except ImportError:  # rclpy before 7.1.4
    EventsExecutor = None

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rclpy.context import Context
    from rclpy.executors import Executor
    from rclpy.task import Future

    from flexros_nodes.interruption import Interruption
    from flexros_nodes.plant import PlantNode

SLICE = 0.2
"""Longest wait of an executor [s]: signals are seen after it, and unbounded waits of EventsExecutor can hang."""

BUSY = 40e-6
"""Time before a cycle is due from which the paced loop watches the clock instead of sleeping [s], chosen."""

_PR_SET_TIMERSLACK = 29
_SWITCH_INTERVAL = 1e-4


def make_executor(context: Context | None) -> Executor:
    """Make the executor that suits the loop best: EventsExecutor where there is one, else SingleThreadedExecutor."""
    if EventsExecutor is None:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(executor: Executor, stop: Future, interrupted: Interruption, plant: PlantNode | None = None) -> None:
    """Spin until a future is done.

    Args:
        executor: Holds the nodes.
        stop: Ends the spinning when it gets a result.
        interrupted: Ends the spinning too.
        plant: Plant to pace by the wall clock, where the run is in real time.
    """
    interrupted.ends(stop)
    if plant is None:
        while not (stop.done() or interrupted()):
            executor.spin_until_future_complete(stop, timeout_sec=SLICE)
        return
    with precise_timing():
        while not (stop.done() or interrupted()):
            schedule = plant.schedule
            remaining = SLICE if schedule is None else schedule.due - BUSY - perf_counter()
            if remaining > 0.0:
                executor.spin_once(timeout_sec=min(remaining, SLICE))
                continue
            while (now := perf_counter()) < schedule.due:
                pass
            schedule.started(now)
            plant.cycle()


@contextmanager
def precise_timing() -> Iterator[None]:
    """Let this thread, and those it starts, wake up on time: no timer slack, no collections of garbage in between.

    The slack of 50 us that Linux adds to every sleep is half a loop's lateness; other systems keep theirs.
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
        yield
    finally:
        if slack:
            slack(_PR_SET_TIMERSLACK, 0, 0, 0, 0)  # 0 restores the default
        sys.setswitchinterval(interval)
        if was_enabled:
            gc.enable()
        gc.unfreeze()
