"""Units of positions and velocities."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.proposal.motion_units import compare_velocity, in_degrees, unit_ratio, velocity_unit

TIME = np.arange(2000) / 500
ANGLE = np.sin(3 * TIME)
RATE = 3 * np.cos(3 * TIME)


@pytest.mark.parametrize(
    ("position", "velocity", "ratio"),
    [(1, 1, 1), (57.3, 57.3, 1), (57.3, 1, 57.3), (1, 57.3, 1 / 57.3), (1, 9.55, 0.1047), (57.3, 9.55, 6)],
)
def test_ratio_of_units(position: float, velocity: float, ratio: float) -> None:
    found = compare_velocity(TIME, position * ANGLE, velocity * RATE)
    assert unit_ratio([found.factor]) == pytest.approx(ratio, rel=1e-3)


def test_opposite_velocity() -> None:
    assert compare_velocity(TIME, ANGLE, -RATE).sign == -1


def test_velocity_that_is_another_signal() -> None:
    noise = np.random.default_rng(1).normal(size=len(TIME))
    assert np.isnan(compare_velocity(TIME, ANGLE, noise).factor)
    assert np.isnan(unit_ratio([float("nan"), float("nan")]))


def test_two_turns_part_radians_from_degrees() -> None:
    assert not in_degrees([ANGLE, 12.0 * ANGLE])
    assert in_degrees([ANGLE, 40.0 * ANGLE])


def test_units_of_velocities_follow_from_those_of_positions() -> None:
    assert [velocity_unit(unit) for unit in ("rad", "deg", "turn", "mm")] == ["rad/s", "deg/s", "turn/s", "mm/s"]
    assert velocity_unit("deg", 6.0) == "rpm"
    assert velocity_unit("rad", 1 / 57.3) == "deg/s"
