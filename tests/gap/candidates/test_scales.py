"""Sizes in a log that ranges of effects are multiples of."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales, scales_of, scales_of_motors
from flexros.record.record import Record
from flexros.robot import load_robot

SIZES = Scales(
    {
        "torque": {"motor_1": 10.0, "motor_2": 4.0},
        "speed": {"motor_1": 2.0, "motor_2": 1.0},
        "angle": {"motor_1": 5.0, "motor_2": 8.0},
        "deflection": {"motor_1": 0.1, "body_1.rz": 0.1, "motor_2": 0.2, "body_2.rz": 0.2},
    }
)


def test_places_have_their_own_sizes_and_others_the_largest() -> None:
    assert SIZES.of("torque", "motor_2") == 4.0
    assert SIZES.of("torque", "tool") == 10.0
    assert SIZES.of("deflection", "body_1.rz") == 0.1


def test_quotients_are_of_the_same_place() -> None:
    assert SIZES.of("torque/speed", "motor_2") == 4.0
    assert SIZES.of("torque/angle", "motor_2") == 0.5
    assert SIZES.of("torque/speed", "all") == 5.0


def test_relative_numbers_have_the_yardstick_one() -> None:
    assert SIZES.of("relative", "motor_1") == 1.0


def test_sizes_are_taken_from_states_and_torques() -> None:
    robot = load_robot("elbow")
    n, rows = robot.n_coordinates, list(robot.motor_rows)
    time = np.linspace(0, 1, 1001)
    states = np.zeros((1001, 2 * n))
    states[:, rows[1]] = 0.5 * np.cos(2 * np.pi * time)
    states[:, n + rows[1]] = 3.0 * np.sin(2 * np.pi * time)
    torque = np.column_stack([np.full(1001, -7.0), np.zeros(1001)])
    sizes = scales_of(robot, states, torque)
    first, second = robot.joint_names
    assert sizes.of("torque", first) == pytest.approx(7.0)
    assert sizes.of("angle", second) == pytest.approx(1.0)
    assert sizes.of("speed", second) == pytest.approx(3.0, rel=1e-3)
    assert sizes.of("deflection", second) == pytest.approx(0.5, rel=1e-3)


def test_sizes_are_never_zero() -> None:
    robot = load_robot("elbow")
    sizes = scales_of(robot, np.zeros((100, 2 * robot.n_coordinates)), np.zeros((100, 2)))
    assert sizes.of("torque/speed", "motor_1") > 0


def test_no_vibration_is_sought_above_half_the_rate_of_a_log() -> None:
    """A log of 48 Hz had named a mode of 37 Hz, which took the place of an inertia."""
    robot = load_robot("elbow")
    sizes = scales_of(robot, np.zeros((100, 2 * robot.n_coordinates)), np.zeros((100, 2)), sample_time=1 / 48)
    for scales, highest in ((sizes, 24.0), (SIZES, 120.0)):
        modes = [one for one in list_candidates(robot, scales) if one.effect.name == "extra_mode"]
        assert modes
        for mode in modes:
            frequency = next(free for free in mode.free if free.name == "frequency")
            assert frequency.high == pytest.approx(highest)
            assert max(frequency.starts) < highest


def test_the_way_through_a_short_pause_is_no_speed_of_the_motors() -> None:
    """A range of viscous friction that it scales would end below what is there."""
    robot, T = load_robot("emps"), 4e-3
    time = T * np.arange(1500)
    run = 0.05 * np.sin(2 * np.pi * 0.5 * time)[:, None]
    pause = np.zeros((100, 1))
    position = np.concatenate([run, pause, run + 0.8])
    valid = np.concatenate([np.ones(1500), np.zeros(100), np.ones(1500)]).astype(bool)
    record = Record("log", T, position, np.ones_like(position), valid, imported=True)
    fastest = scales_of_motors(robot, record).of("speed", "motor_1")
    assert fastest == pytest.approx(0.05 * np.pi, rel=0.1)
