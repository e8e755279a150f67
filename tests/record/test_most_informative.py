"""The part of a long log that tells most."""

from __future__ import annotations

import numpy as np

from flexros.record.most_informative import most_informative
from flexros.record.record import Record

T = 1e-2


def record(moving: slice, n: int = 4000) -> Record:
    time = T * np.arange(n)
    position = np.zeros((n, 2))
    position[moving] = np.stack([np.sin(4 * time), np.cos(5 * time)], axis=-1)[moving]
    return Record(name="long", sample_time=T, position=position, torque=np.zeros((n, 2)), valid=np.ones(n, dtype=bool))


def test_the_part_in_which_the_motors_move_is_used_and_named() -> None:
    part = most_informative(record(slice(2000, 3000)), 2000)
    assert part.n_samples == 1000
    assert part.begin / T == 2000 or abs(part.begin / T - 2000) <= 100
    assert "10 s from" in part.warnings[-1]


def test_a_log_that_is_short_enough_stays_as_it_is() -> None:
    whole = record(slice(0, 4000))
    assert most_informative(whole, 8000) is whole


def test_a_motor_that_stands_still_does_not_decide() -> None:
    still = record(slice(0, 4000))
    still.position[:, 1] = 0.0
    still.position[:3000, 0] *= 0.1
    assert most_informative(still, 2000).begin >= 2000 * T
