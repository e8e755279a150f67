"""Crowds: how many effects, where, and none that explain each other."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.validation.blind.draw.case_robots import case_robot
from flexros.validation.blind.draw.crowd import ALIKE, FEWEST, MOST, draw_crowd
from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.plant.laws import OUTSIDE_LAWS

ROBOTS = ("four_mass_linear", "elbow", "e12", "rigid_six_axis")


@pytest.mark.parametrize("name", ROBOTS)
def test_a_crowd_has_3_to_12_effects_at_places_of_the_robot(name: str) -> None:
    robot = case_robot(name)
    for seed in range(30):
        crowd = draw_crowd(robot, outside=False, random=np.random.default_rng(seed))
        assert FEWEST <= len(crowd) <= MOST
        assert len(set(crowd)) == len(crowd)
        assert all(place in places_of(effect, robot) for effect, place in crowd)


def test_no_two_effects_at_a_motor_explain_each_other() -> None:
    robot = case_robot("rigid_six_axis")
    for seed in range(30):
        crowd = draw_crowd(robot, outside=False, random=np.random.default_rng(seed))
        for motor in robot.joint_names:
            here = {effect for effect, place in crowd if place == motor}
            assert not any(len(here & group) > 1 for group in ALIKE)


def test_viscous_and_dry_friction_may_sit_at_one_motor() -> None:
    robot = case_robot("elbow")
    crowds = [draw_crowd(robot, False, np.random.default_rng(seed)) for seed in range(30)]
    assert any({("viscous_friction", "motor_1"), ("coulomb_friction", "motor_1")} <= set(crowd) for crowd in crowds)


def test_one_cause_outside_the_library_where_there_shall_be_one() -> None:
    crowd = draw_crowd(case_robot("elbow"), True, np.random.default_rng(1))
    assert sum(effect in OUTSIDE_LAWS for effect, _ in crowd) == 1


def test_some_joints_of_an_arm_are_clean() -> None:
    crowds = [draw_crowd(case_robot("rigid_six_axis"), False, np.random.default_rng(seed)) for seed in range(30)]
    numbers = {len({place for _, place in crowd if place.startswith("motor")}) for crowd in crowds}
    assert min(numbers) <= 2
    assert max(numbers) >= 4
