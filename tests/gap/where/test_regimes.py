"""Parts of a motion."""

from __future__ import annotations

import numpy as np

from flexros.gap.where.motion import MotorMotion
from flexros.gap.where.regimes import REGIMES, around, regimes

T = 1e-3


def moved(speed: np.ndarray) -> MotorMotion:
    column = speed[:, None]
    none = np.full_like(column, np.nan)
    return MotorMotion(column, column, np.gradient(column, axis=0), column, np.abs(column), none, none)


def test_reversal_is_where_the_speed_changes_its_sign() -> None:
    time = T * np.arange(4000)
    found = regimes(moved(np.cos(2 * np.pi * time / 2)), 0, T)["reversal"]
    changes = np.flatnonzero(np.diff(np.cos(2 * np.pi * time / 2) > 0))
    assert all(found[row] for row in changes)
    assert not found[changes[0] - 40 : changes[0] - 25].any()
    assert found.sum() < 100 * len(changes)


def test_fast_turning_back_and_forth_is_vibration() -> None:
    time = T * np.arange(4000)
    found = regimes(moved(np.cos(2 * np.pi * 20 * time)), 0, T)
    assert found["vibration"].mean() > 0.9
    assert not found["reversal"][100:-100].any()


def test_a_rest_between_moves_is_standstill_and_no_reversal() -> None:
    speed = np.concatenate([np.ones(500), np.zeros(500), np.ones(500)])
    found = regimes(moved(speed), 0, T)
    assert found["standstill"][500:1000].all()
    assert not found["reversal"].any()


def test_regimes_of_speed_do_not_overlap() -> None:
    time = T * np.arange(6000)
    found = regimes(moved(np.sin(2 * np.pi * time) * (time < 4)), 0, T)
    total = sum(found[name].astype(int) for name, regime in REGIMES.items() if regime.kind == "speed")
    assert total.max() == 1


def test_all_regimes_are_computed() -> None:
    assert set(regimes(moved(np.ones(100)), 0, T)) == set(REGIMES)


def test_events_are_widened() -> None:
    event = np.zeros(300, dtype=bool)
    event[100] = True
    assert np.flatnonzero(around(event, T)).tolist() == list(range(80, 161))
