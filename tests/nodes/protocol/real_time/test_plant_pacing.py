"""Real-time cycles of the plant, with synthetic times."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros_nodes.protocol.real_time.plant_pacing import MOST_MESSAGES, HeldCommand, PlantPacing
from flexros_nodes.protocol.real_time.schedule import Schedule

T = 5e-4
FIRST, NEXT = np.array([1.0]), np.array([2.0])


class Cycles:
    """Commands passed to the cycles."""

    def __init__(self) -> None:
        self.commands: list[float | None] = []
        self.waiting: list[float | None] = []
        self.pacing = PlantPacing(self.note, self.receive)

    def note(self, command: FloatArray | None) -> None:
        self.commands.append(None if command is None else float(command[0]))

    def receive(self) -> bool:
        """Process a queued command; None is a message without one."""
        if not self.waiting:
            return False
        if (command := self.waiting.pop(0)) is not None:
            self.pacing.offer(np.array([command]))
        return True


@pytest.fixture
def cycles() -> Cycles:
    cycles = Cycles()
    cycles.pacing.begin(np.array([1.0]), T, patience=2 * T)
    return cycles


def test_nothing_is_paced_before_the_first_command() -> None:
    pacing = Cycles().pacing
    assert not pacing.has_begun
    assert pacing.answered()
    assert pacing.schedule is None


def test_first_cycle_is_due_a_sample_time_after_the_first_command(cycles: Cycles) -> None:
    cycles.pacing.go_on(7.0)
    assert cycles.pacing.schedule is not None
    assert cycles.pacing.schedule.due == 7.0 + T


def test_cycles_hold_the_last_command_until_it_is_too_old(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    for _ in range(4):
        cycles.pacing.cycle()
    assert cycles.commands == [1.0, 1.0, 1.0, None]
    assert cycles.pacing.figures(Schedule.statistics)["missed_commands"] == 0  # no period as yet


def test_command_is_found_among_what_has_come(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    cycles.pacing.cycle()
    assert not cycles.pacing.answered()
    cycles.waiting = [None, None, 2.0, None]
    assert cycles.pacing.answered()
    cycles.pacing.cycle()
    assert cycles.commands == [1.0, 2.0]
    assert cycles.waiting == [None]


def test_flood_does_not_keep_a_cycle_for_ever(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    cycles.pacing.cycle()
    cycles.waiting = [None] * 10 * MOST_MESSAGES
    cycles.pacing.cycle()
    assert cycles.commands == [1.0, 1.0]
    assert len(cycles.waiting) == 9 * MOST_MESSAGES


def test_pause_counts_neither_as_a_period_nor_as_a_miss(cycles: Cycles) -> None:
    pacing = cycles.pacing
    pacing.go_on(0.0)
    for first in (0.0, 1000.0):
        if first:
            pacing.halt()
            pacing.cycle()  # due when the pause came
            pacing.go_on(first)
        for _ in range(100):
            assert pacing.schedule is not None
            pacing.schedule.started(pacing.schedule.due)
            pacing.offer(np.array([2.0]))
            pacing.cycle()
    figures = pacing.figures(Schedule.statistics)
    assert len(cycles.commands) == 200
    assert (figures["missed_commands"], figures["cycles"], figures["late"]) == (0, 200, 0)
    assert figures["period_max_us"] == pytest.approx(500.0)
    assert figures["rate_hz"] == pytest.approx(2000.0)


def test_figures_join_misses_and_schedule(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    for _ in range(3):
        assert cycles.pacing.schedule is not None
        cycles.pacing.schedule.started(cycles.pacing.schedule.due)
        cycles.pacing.cycle()
    figures = cycles.pacing.figures(Schedule.statistics)
    assert (figures["missed_commands"], figures["cycles"], figures["late"]) == (2, 3, 0)


def test_step_does_one_cycle_in_a_pause(cycles: Cycles) -> None:
    cycles.pacing.step()
    cycles.pacing.cycle()
    assert cycles.commands == [1.0]


def test_reset_returns_to_the_state_before_the_first_command(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    cycles.pacing.reset()
    cycles.pacing.cycle()
    assert not cycles.pacing.has_begun
    assert cycles.commands == []


def test_before_the_first_cycle_nothing_is_missed() -> None:
    pacing = Cycles().pacing
    pacing.prioritised = True
    assert pacing.figures(Schedule.statistics) == {"missed_commands": 0, "real_time_priority": True}


# The held command.


def test_newest_command_is_applied_once() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.1)
    held.offer(NEXT)
    assert held.is_new
    assert held.take() is NEXT
    assert not held.is_new
    assert held.missed == 0


def test_last_command_is_held_and_misses_are_counted() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.1)
    assert [held.take() is FIRST for _ in range(4)] == [True] * 4
    assert held.missed == 3


def test_command_that_is_too_old_is_dropped() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.0025)
    taken = [held.take() for _ in range(7)]
    assert taken[5] is FIRST
    assert taken[6] is None


def test_late_command_is_held_though_its_sample_was_missed() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.001)
    held.take()
    for _ in range(9):
        held.offer(NEXT, late=True)
        assert not held.is_new
        assert held.take() is NEXT
    assert held.missed == 9


def test_command_in_between_restarts_the_patience() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.001)
    for _ in range(5):
        held.offer(NEXT)
        assert held.take() is NEXT
        assert held.take() is NEXT
