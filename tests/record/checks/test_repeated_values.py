"""Values that repeat at rest and at turning points, and those that do not follow the motor."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.checks.repeated_values import comes_to_rest


@pytest.mark.parametrize(("cut", "rests"), [(0.0, True), (1e-4, False)])
def test_turning_point_in_numbers_of_six_digits_is_rest(cut: float, rests: bool) -> None:
    """Beside the turning point values repeat too, but a few samples away from it they do no more."""
    t = np.arange(-300, 301)
    values = np.maximum(np.round(-0.5 + 2e-8 * t**2, 6), -0.5 + cut)
    first, *_, last = np.flatnonzero(values == values.min())
    assert comes_to_rest(values, int(first), int(last - first + 1), 0.0) is rests


@pytest.mark.parametrize(("jump", "rests"), [(0.0, True), (3e-4, False)])
def test_joint_that_sticks_and_breaks_free_is_at_rest(jump: float, rests: bool) -> None:
    """It comes slowly and leaves fast, but from where it stuck; an encoder that was stuck jumps to where it is then."""
    came, stuck, left = -1e-6 * np.arange(30, 0, -1) ** 2, np.zeros(12), -1e-4 * np.cumsum(np.arange(1, 20))
    values = 1.0 + np.concatenate([came, stuck, left - jump])
    assert comes_to_rest(values, 30, 12, 2e-5) is rests
