from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects import parse_effect
from flexros.identify.experiment.slow_motion import SlowSine
from flexros.robot.robot import load_robot
from flexros.validation.campaigns.study.real_robot import unmodelled_effects

if TYPE_CHECKING:
    from flexros.scenario.scenario import Scenario


def test_every_motor_of_six_axis_has_a_hardening_gear_friction_and_ripple() -> None:
    robot = load_robot("six_axis")
    placed = [parse_effect(text, "test") for text in unmodelled_effects(robot)]
    assert len(placed) == 18
    for each in placed:
        each.check_location(robot)
    assert {each.effect.name for each in placed} == {"nonlinear_stiffness", "coulomb_friction", "torque_ripple"}


def test_robot_without_torque_limits_stays_linear(small_scenario: Scenario) -> None:
    assert unmodelled_effects(load_robot("e12")) == ()
    assert small_scenario.plant.effects == ()


def test_positions_come_from_the_design_and_motors_seldom_turn_back(small_scenario: Scenario) -> None:
    specification = small_scenario.identification
    assert specification is not None
    assert len(set(specification.positions)) == 3
    assert isinstance(specification.slow_motion, SlowSine)
    assert specification.slow_motion.speeds(2).tolist() == [0.1, 0.1]
