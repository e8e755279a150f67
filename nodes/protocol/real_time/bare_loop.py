"""A loop that sleeps until each due time and does nothing else: what the machine itself allows at that moment."""

from __future__ import annotations

from time import perf_counter, sleep
from typing import TYPE_CHECKING

from flexros_nodes.protocol.real_time.precise_timing import precise_timing
from flexros_nodes.protocol.real_time.schedule import Schedule

if TYPE_CHECKING:
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics

BUSY = 130e-6
"""Time before a due cycle from which a paced loop polls instead of sleeping [s], chosen."""


def bare_loop(sample_time: float, duration: float) -> PeriodStatistics | None:
    """Measure the schedule of an empty loop, with the priority and the waits of the loop of the plant.

    Args:
        sample_time: Time between two cycles [s].
        duration: Time that it takes [s].

    Returns:
        Periods and lateness; None where the time is shorter than two cycles.
    """
    schedule = Schedule(sample_time)
    with precise_timing():
        schedule.begin(perf_counter() + sample_time)
        for _ in range(round(duration / sample_time)):
            if (remaining := schedule.due - BUSY - perf_counter()) > 0.0:
                sleep(remaining)
            while (now := perf_counter()) < schedule.due:
                pass
            schedule.started(now)
    return schedule.statistics()
