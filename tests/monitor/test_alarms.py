"""Alarms: what raises them, how long they stay, when they begin."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.monitor.alarms import Alarms, Level
from flexros.monitor.thresholds import Thresholds

WINDOW = 100_000_000


def alarms() -> Alarms:
    """Two motors; warnings from 2, 1.5 and 1.2, alarms from 4, 3 and 2 on."""
    ones = np.ones((3, 4))
    return Alarms(Thresholds(ones * [[2.0], [1.5], [1.2]], ones * [[4.0], [3.0], [2.0]]))


def feed(one: Alarms, first: int, values: list[list[float]]) -> int:
    for k, value in enumerate(values, first):
        one.take(k * WINDOW, np.array(value))
    return first + len(values)


def test_noise_raises_nothing() -> None:
    one = alarms()
    feed(one, 0, 200 * [[1.0, 1.0, 1.1, 0.9]])
    assert one.levels(199 * WINDOW).tolist() == [0, 0]
    assert (one.raised, one.warned) == (0, 0)


def test_one_window_is_enough_for_a_large_gap_and_names_its_motor() -> None:
    one = alarms()
    end = feed(one, 0, 5 * [[1.0] * 4] + [[1.0, 1.0, 1.0, 5.0]])
    state = one.states((end - 1) * WINDOW)
    assert [motor.level for motor in state] == [Level.OK, Level.ALARM]
    assert state[1].since == 5 * WINDOW
    assert state[1].share == pytest.approx(4 / 3)
    assert state[0].share == 0.0


def test_a_small_gap_raises_a_warning_then_an_alarm() -> None:
    one = alarms()
    feed(one, 0, 10 * [[1.8, 1.0, 1.0, 1.0]])
    assert one.levels(9 * WINDOW).tolist() == [Level.WARNING, Level.OK]
    assert one.states(9 * WINDOW)[0].since == 0
    feed(one, 10, 90 * [[2.2, 1.0, 1.0, 1.0]])
    assert one.levels(99 * WINDOW).tolist() == [Level.ALARM, Level.OK]
    assert (one.raised, one.warned) == (1, 1)


def test_an_alarm_stays_for_ten_seconds_and_the_next_one_is_a_new_one() -> None:
    one = alarms()
    end = feed(one, 0, [[9.0, 1.0, 1.0, 1.0]] + 99 * [[0.2] * 4])
    assert one.levels((end - 1) * WINDOW)[0] == Level.ALARM
    end = feed(one, end, 20 * [[0.2] * 4])
    assert one.levels((end - 1) * WINDOW)[0] == Level.OK
    end = feed(one, end, [[9.0, 1.0, 1.0, 1.0]])
    assert one.states((end - 1) * WINDOW)[0].since == (end - 1) * WINDOW
    assert one.raised == 2


def test_sums_are_reset_by_a_restart() -> None:
    one = alarms()
    feed(one, 0, 9 * [[1.9, 1.0, 1.0, 1.0]])
    one.restart()
    feed(one, 30, 9 * [[1.9, 1.0, 1.0, 1.0]])
    assert one.warned == 0


def test_a_clock_that_is_reset_ends_alarms() -> None:
    one = alarms()
    feed(one, 500, [[9.0, 1.0, 1.0, 1.0]])
    one.forget()
    feed(one, 0, [[1.0] * 4])
    assert one.levels(0).tolist() == [0, 0]


def test_a_robot_that_is_lost_is_an_alarm_of_all_motors() -> None:
    one = alarms()
    one.diverged(7 * WINDOW)
    one.diverged(8 * WINDOW)
    assert one.levels(8 * WINDOW).tolist() == [Level.ALARM, Level.ALARM]
    assert one.raised == 1
