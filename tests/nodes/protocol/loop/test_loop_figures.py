"""What a plant tells of its schedule."""

from __future__ import annotations

import numpy as np

from flexros_nodes.protocol.loop.loop_figures import timing_figures
from flexros_nodes.protocol.real_time.held_command import HeldCommand
from flexros_nodes.protocol.real_time.schedule import CycleCounts


def test_before_the_first_cycle_nothing_is_missed() -> None:
    assert timing_figures(True, None, None) == {"missed_commands": 0, "real_time_priority": True}


def test_schedule_stands_beside_what_was_missed() -> None:
    cycles = CycleCounts(0.5e-3)
    for _ in range(4):
        cycles.add(0.5e-3, 1e-6)
    held = HeldCommand(np.zeros(1), 0.5e-3, 0.1)
    for _ in range(3):
        held.take()
    figures = timing_figures(False, held, cycles.statistics())
    assert (figures["missed_commands"], figures["real_time_priority"], figures["late"]) == (2, False, 0)
    assert figures["cycles"] == 4
