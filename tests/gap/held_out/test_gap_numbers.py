"""The gap as it is stated, by signal."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.held_out.errors_ahead import AheadErrors
from flexros.gap.held_out.gap_numbers import signal_gaps
from flexros.robot import load_robot


def errors(*ratios: float, floor: float) -> AheadErrors:
    """Errors whose rms is a multiple of the floor, by motor."""
    squares = np.repeat(np.square([ratios]), 7, axis=0)
    return AheadErrors(squares, 50 * np.arange(7), np.full(len(ratios), floor))


def test_every_motor_has_its_rms_before_and_after() -> None:
    first, second = signal_gaps(load_robot("e12"), errors(10, 3, floor=1e-4), errors(1.5, 1, floor=1e-4))
    assert (first.signal, first.unit) == ("motor_1 position, 0.1 s ahead", "mrad")
    assert (first.before, first.after, first.floor, first.rival) == pytest.approx((1.0, 0.15, 0.1, None))
    assert second.before == pytest.approx(0.3)


def test_small_errors_and_sliding_motors_have_units_of_their_own() -> None:
    (gap,) = signal_gaps(load_robot("emps"), errors(4, floor=1e-6), rival=errors(2, floor=1e-6))
    assert (gap.unit, gap.before, gap.rival) == ("µm", pytest.approx(4.0), pytest.approx(2.0))
