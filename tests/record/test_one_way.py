"""Motors that move in one direction only."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.one_way import moves_one_way
from flexros.record.record import Record


@pytest.mark.parametrize(("back", "one_way"), [(0.0, True), (0.01, True), (0.1, False), (1.0, False)])
def test_a_little_of_the_motion_may_be_back(back: float, one_way: bool) -> None:
    there = np.linspace(0.0, 1.0, 500)
    position = np.concatenate([there, 1.0 - back * there])[:, None]
    valid = np.ones(len(position), dtype=bool)
    assert moves_one_way(Record("log", 0.001, position, 0 * position, valid), 0) is one_way


def test_a_motor_that_rests_moves_in_no_direction() -> None:
    position = 1e-4 * np.random.default_rng(1).standard_normal((500, 1))
    assert not moves_one_way(Record("log", 0.001, position, 0 * position, np.ones(500, dtype=bool)), 0)
