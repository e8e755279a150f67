"""Largest factor on an excitation."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.experiment.margin import Swing, smallest_margin

ONE = np.ones(2)


def swing(offset: float, values: list[float], low: float = -10.0, high: float = 10.0) -> Swing:
    level = np.array([offset, 0.0])
    return Swing("torque", level, level, np.array([values, [0.0] * len(values)]).T, low * ONE, high * ONE)


def test_room_above_the_offset_counts() -> None:
    margin = smallest_margin([swing(4.0, [0.0, 3.0, -3.0])])
    assert margin.factor == pytest.approx(2.0)
    assert (margin.motor, margin.name) == (0, "torque")
    assert (margin.reached, margin.allowed, margin.offset) == (7.0, 10.0, 4.0)


def test_room_below_the_offset_counts_too() -> None:
    margin = smallest_margin([swing(-4.0, [1.0, -12.0])])
    assert margin.factor == pytest.approx(0.5)
    assert (margin.reached, margin.allowed, margin.offset) == (-16.0, -10.0, -4.0)


def test_offset_beyond_the_limit_leaves_nothing() -> None:
    assert smallest_margin([swing(11.0, [0.0, 0.1])]).factor == 0.0


def test_tightest_of_several_is_found() -> None:
    assert smallest_margin([swing(0.0, [1.0]), swing(0.0, [5.0]), swing(0.0, [2.0])]).factor == pytest.approx(2.0)


def test_offset_may_be_a_range_and_change_with_time() -> None:
    low, high = np.array([[-1.0, 0.0], [-2.0, 0.0]]), np.array([[8.0, 0.0], [1.0, 0.0]])
    both = Swing("torque", low, high, np.array([[1.0, 0.0], [-4.0, 0.0]]), -10.0 * ONE, 10.0 * ONE)
    assert smallest_margin([both]).factor == pytest.approx(2.0)
    assert smallest_margin([both]).offset == -2.0 or smallest_margin([both]).offset == 8.0


def test_nothing_swings_nothing_is_tight() -> None:
    assert smallest_margin([swing(0.0, [0.0])]).factor == np.inf
