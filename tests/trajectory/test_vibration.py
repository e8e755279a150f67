"""Sums of cosines about a point: derivatives, periods, rest at both ends."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.trajectory import vibration as module
from flexros.trajectory.trajectory import Move
from flexros.trajectory.vibration import Vibration


def vibration() -> Vibration:
    return Vibration(
        centre=np.array([0.3, -1.0]),
        frequency=np.array([1.0, 3.0, 7.0]),
        amplitude=np.array([[0.2, 0.05, 0.01], [0.1, 0.0, 0.02]]),
        phase=np.array([[0.1, 2.0, 1.0], [0.5, 0.0, 4.0]]),
        duration=3.0,
        fade=0.5,
    )


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_derivatives_are_those_of_differences(order: int) -> None:
    path, step = vibration(), 1e-5
    t = np.array([0.13, 0.4, 1.1, 2.2, 2.6, 2.93])
    low, high = (path.derivatives(t + sign * step, order - 1)[order - 1] for sign in (-1.0, 1.0))
    expected = (high - low) / (2 * step)
    actual = path.derivatives(t, order)[order]
    np.testing.assert_allclose(actual, expected, rtol=1e-6, atol=1e-6 * np.abs(actual).max())


def test_begins_and_ends_at_rest_in_its_centre() -> None:
    path = vibration()
    ends = path.derivatives(np.array([0.0, path.duration]), 4)
    np.testing.assert_allclose(ends[0], np.tile(path.centre, (2, 1)), atol=1e-15)
    np.testing.assert_allclose(ends[1:], 0.0, atol=1e-8)


def test_repeats_between_its_fades() -> None:
    path = vibration()
    t = np.linspace(0.5, 1.5, 50)
    np.testing.assert_allclose(path.derivatives(t + 1.0, 0), path.derivatives(t, 0), atol=1e-12)


def test_speed_stays_below_the_pace() -> None:
    path = vibration()
    speed = np.abs(path.derivatives(np.linspace(0.0, 3.0, 3001), 1)[1])
    assert np.all(speed.max(axis=0) <= path.coordinate_pace)
    assert np.max(np.linalg.norm(path.derivatives(np.linspace(0.0, 3.0, 3001), 1)[1], axis=1)) <= path.pace


def test_its_law_is_the_time() -> None:
    path = vibration()
    move, t = Move(path, path.law()), np.array([0.2, 1.7])
    np.testing.assert_allclose(move.evaluate(t, 4), path.derivatives(t, 4), rtol=1e-12)


def test_many_times_are_evaluated_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    path, t = vibration(), np.linspace(0.0, 3.0, 1001)
    at_once = path.derivatives(t, 4)
    monkeypatch.setattr(module, "_ROWS_AT_ONCE", 100)
    np.testing.assert_allclose(path.derivatives(t, 4), at_once, rtol=1e-12, atol=1e-9)
