"""Candidate positions: within their ranges, evenly spread, physically possible, repeatable."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.candidates import TORQUE_SHARE, candidate_positions, default_ranges
from flexros.robot import load_robot

pytestmark = pytest.mark.slow


def test_positions_fill_the_ranges_and_repeat_with_the_seed() -> None:
    robot = load_robot("e12")
    ranges = [[-0.5, 0.1], [0.2, 1.2]]
    found = candidate_positions(robot, 64, ranges, seed=3)
    assert found.gears.shape == (64, 2)
    assert np.all((found.gears >= np.array(ranges)[:, 0]) & (found.gears <= np.array(ranges)[:, 1]))
    cells = np.floor((found.gears - [-0.5, 0.2]) / [0.6, 1.0] * 4).astype(int)
    assert len({tuple(cell) for cell in cells.tolist()}) == 16
    assert np.array_equal(found.gears, candidate_positions(robot, 64, ranges, seed=3).gears)
    assert not np.array_equal(found.gears, candidate_positions(robot, 64, ranges, seed=4).gears)


def test_motor_positions_hold_the_gears_under_gravity() -> None:
    robot = load_robot("six_axis")
    found = candidate_positions(robot, 5)
    for gears, motors in zip(found.gears, found.motor_positions, strict=True):
        state = robot.equilibrium(robot.arm_from_gears(gears), motor_position=motors)
        assert state[list(robot.gear_rows)] == pytest.approx(gears, abs=1e-9)
        assert np.all(np.abs(robot.holding_torque(state)) <= TORQUE_SHARE * robot.torque_limits)


def test_positions_that_gravity_forbids_are_refused_and_counted() -> None:
    robot = load_robot("six_axis").with_values({"body_7.mass": 400})
    found = candidate_positions(robot, 30)
    assert found.refused["gravity takes more than 60% of a torque limit"] > 10
    assert len(found.gears) == 30


def test_positions_of_a_falling_arm_are_refused() -> None:
    soft = load_robot("six_axis").with_values({"body_2.ry.stiffness": 1e3})
    with pytest.raises(
        InputError, match=r"six_axis can be held in only \d+ of \d+ positions within the ranges .* give"
    ):
        candidate_positions(soft, 30)


def test_default_ranges_lie_about_home() -> None:
    robot = load_robot("six_axis")
    middle = default_ranges(robot).mean(axis=1)
    assert middle == pytest.approx(robot.home[list(robot.gear_rows)])


@pytest.mark.parametrize(
    ("number", "ranges", "message"),
    [
        (0, None, "0 candidate positions were requested"),
        (4, [[0, 1]], "robot e12 needs 2 pairs of smallest and largest coordinate"),
        (4, [[0, 1], [1, 0]], "robot e12 needs 2 pairs of smallest and largest coordinate"),
    ],
)
def test_wrong_arguments_are_explained(number: int, ranges: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        candidate_positions(load_robot("e12"), number, ranges)
