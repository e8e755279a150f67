"""The command of a plant in real time."""

from __future__ import annotations

import numpy as np

from flexros_nodes.protocol.real_time.held_command import HeldCommand

FIRST, NEXT = np.array([1.0]), np.array([2.0])


def test_newest_command_is_taken_once() -> None:
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


def test_command_that_is_too_old_is_no_more() -> None:
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


def test_command_in_between_starts_the_patience_anew() -> None:
    held = HeldCommand(FIRST, 5e-4, 0.001)
    for _ in range(5):
        held.offer(NEXT)
        assert held.take() is NEXT
        assert held.take() is NEXT
