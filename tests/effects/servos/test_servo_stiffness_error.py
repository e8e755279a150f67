"""Errors of the stiffness of servos."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.effects.servos.servo_stiffness_error import ServoStiffnessError
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales
from flexros.robot import load_robot
from flexros.simulate.plant import Plant
from tests.gap.servo_logs import T, servo_robot

GAINS = {"servo_stiffness_error", "servo_damping_error", "servo_feedforward_error", "servo_integral"}


def test_stiffness_is_scaled() -> None:
    placed = place_effects(servo_robot(), [parse_effect("servo_stiffness_error@motor_1:relative=-0.25", "test")])
    assert placed.robot.parameters["motor_1.servo_stiffness"].value == pytest.approx(45.0)


def test_motors_without_servo_have_none() -> None:
    assert ServoStiffnessError().locations(load_robot("elbow")) == ()


@pytest.mark.parametrize(
    ("commands", "sought", "left_out"),
    [
        ("position", "servo_stiffness_error", "torque_gain_error"),
        ("torque", "torque_gain_error", "servo_stiffness_error"),
    ],
)
def test_it_takes_the_place_of_the_torque_gain(commands: str, sought: str, left_out: str) -> None:
    robot = servo_robot().commanded_by(commands)  # type: ignore[arg-type]
    names = {one.effect.name for one in list_candidates(robot, Scales({}))}
    assert sought in names
    assert left_out not in names
    assert {ServoStiffnessError.name, TorqueGainError.name} == {sought, left_out}


def test_gains_that_are_known_have_no_errors_and_no_tolerance() -> None:
    robot = servo_robot(0.5, tolerance=0.1, known=True).commanded_by("position")
    assert not any(one.effect.name in GAINS for one in list_candidates(robot, Scales({}), measured=True))
    assert robot.parameters["motor_1.servo_stiffness"].tolerance == 0.0
    uncertain = servo_robot(0.5, tolerance=0.1).commanded_by("position")
    assert {one.effect.name for one in list_candidates(uncertain, Scales({}), measured=True)} >= GAINS
    assert uncertain.parameters["motor_1.servo_stiffness"].tolerance == 0.1


@pytest.mark.parametrize("text", ["servo_stiffness_error@motor_1:relative=0.5", "coulomb_friction@motor_1:level=0.2"])
def test_the_joint_settles_where_the_servo_balances_its_weight(text: str) -> None:
    placed = place_effects(servo_robot().commanded_by("position"), [parse_effect(text, "test")])
    stiffness = placed.robot.parameters["motor_1.servo_stiffness"].value
    plant = Plant(placed.robot, T, placed.robot.equilibrium([0.5]), laws=placed.laws, torque=np.array([0.5]))
    for _ in range(1500):
        plant.advance(np.array([0.5]))
    friction = 0.2 if placed.laws else 0.0
    q = float(plant.state[0])
    assert abs(stiffness * (0.5 - q) + 1.5 * 9.81 * 0.2 * np.sin(q)) <= friction + 1e-6
    assert abs(plant.state[1]) < 1e-6
