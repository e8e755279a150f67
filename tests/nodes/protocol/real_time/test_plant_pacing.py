"""Cycles of a plant in real time, with times made up."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros_nodes.protocol.real_time.plant_pacing import MOST_MESSAGES, PlantPacing
from flexros_nodes.protocol.real_time.schedule import Schedule

T = 5e-4


class Cycles:
    """What the cycles were given."""

    def __init__(self) -> None:
        self.commands: list[float | None] = []
        self.waiting: list[float | None] = []
        self.pacing = PlantPacing(self.note, self.receive)

    def note(self, command: FloatArray | None) -> None:
        self.commands.append(None if command is None else float(command[0]))

    def receive(self) -> bool:
        """Take what waits: a command, or None for a message that is none."""
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


def test_step_does_one_cycle_in_a_pause(cycles: Cycles) -> None:
    cycles.pacing.step()
    cycles.pacing.cycle()
    assert cycles.commands == [1.0]


def test_it_forgets_what_was_before_the_first_sample(cycles: Cycles) -> None:
    cycles.pacing.go_on(0.0)
    cycles.pacing.forget()
    cycles.pacing.cycle()
    assert not cycles.pacing.has_begun
    assert cycles.commands == []
