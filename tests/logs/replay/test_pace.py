"""Due time of a message."""

from __future__ import annotations

import math

import pytest

from flexros.logs.replay.pace import ReplayPace

SECOND = 10**9


@pytest.mark.parametrize(("rate", "due"), [(1.0, 103.0), (0.1, 130.0), (10.0, 100.3), (math.inf, 100.0)])
def test_rate(rate: float, due: float) -> None:
    pace = ReplayPace(rate)
    pace.begin(100.0, 5 * SECOND)
    assert pace.due(8 * SECOND) == pytest.approx(due)


@pytest.mark.parametrize(("rate", "due"), [(2.0, 111.0), (math.inf, 110.0)])
def test_a_pause_takes_no_time_of_the_log(rate: float, due: float) -> None:
    pace = ReplayPace(rate)
    pace.begin(100.0, 0)
    pace.pause(101.0)
    pace.pause(102.0)
    assert pace.due(0) == math.inf
    pace.resume(110.0)
    pace.resume(120.0)
    assert pace.due(4 * SECOND) == pytest.approx(due)


def test_a_pause_before_the_beginning_keeps_the_first_message() -> None:
    pace = ReplayPace()
    pace.begin(100.0, 7 * SECOND)
    pace.pause(99.0)
    pace.resume(200.0)
    assert pace.due(7 * SECOND) == 200.0


def test_the_rate_may_change_on_the_way_and_in_a_pause() -> None:
    pace = ReplayPace(1.0)
    pace.begin(0.0, 0)
    pace.change_rate(4.0, 2.0)
    assert pace.due(6 * SECOND) == pytest.approx(3.0)
    pace.pause(3.0)
    pace.change_rate(0.5, 4.0)
    pace.resume(5.0)
    assert pace.due(7 * SECOND) == pytest.approx(7.0)
