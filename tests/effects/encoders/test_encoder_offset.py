"""A reading that errs by a constant."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.robot import load_robot
from flexros.simulate.plant import Plant
from tests.gap.servo_logs import T, servo_robot


def test_measured_position_is_off_and_the_true_one_is_not() -> None:
    robot = load_robot("two_mass")
    placed = place_effects(robot, [parse_effect("encoder_offset@motor_1:offset=-0.02", "test")])
    plant = Plant(placed.robot, robot.sample_time, np.array([0.0, 0.3, 0.0, 0.0]), laws=placed.laws)
    assert plant.measure()[0] == pytest.approx(0.28, abs=1e-15)
    assert plant.state[1] == 0.3


def test_a_servo_acts_on_the_measured_position() -> None:
    measured = []
    for offset in (0.0, -0.02):
        robot = servo_robot(mass=1e-9, integral=3.0).commanded_by("position")  # no weight tells where the arm is
        placed = place_effects(robot, [parse_effect(f"encoder_offset@motor_1:offset={offset}", "test")])
        start = np.array([0.1 - offset, 0.0])
        plant = Plant(placed.robot, T, start, laws=placed.laws, torque=np.array([0.1]), substeps=4)
        shown = [plant.measure()[0]]
        for wanted in [0.1] * 5 + [0.3] * 20:
            plant.advance(np.array([wanted]))
            shown.append(plant.measure()[0])
        measured.append(shown)
    np.testing.assert_allclose(measured[1], measured[0], atol=1e-9)
    np.testing.assert_allclose(measured[0][:6], 0.1, atol=1e-9)
    assert measured[0][-1] > 0.2


@pytest.mark.parametrize(("name", "sought"), [("elbow", [True, True]), ("e12", [False]), ("emps", [False])])
def test_it_is_sought_where_torques_depend_on_the_position(name: str, sought: list[bool]) -> None:
    robot = load_robot(name)
    assert [EncoderOffset().sought(robot, motor) for motor in robot.joint_names][: len(sought)] == sought


def test_it_is_not_sought_around_a_vertical_first_axis() -> None:
    robot = load_robot("six_axis")
    found = [EncoderOffset().sought(robot, motor) for motor in robot.joint_names]
    assert not found[0]
    assert all(found[1:])
