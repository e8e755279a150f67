"""Gains of servos that are off by far are read off the weight that they carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.effects.servos import ServoDampingError, ServoStiffnessError
from flexros.gap.candidates.tolerance import Tolerance, scaled_by_gravity
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.torques.rough_gains import carrying_stiffness, likely_gains, rough_gains, with_likely_gains
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.settings import DiagnosisSettings, ServoStartSettings
from flexros.record.record import Record
from flexros.robot import Robot
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import servo_log, servo_robot

FRICTION = "coulomb_friction@motor_1:level=0.3"
TRUE = 60.0


def robot_with(factor: float) -> Robot:
    """The joint with other gains in its file."""
    return servo_robot().with_values({"motor_1.servo_stiffness": TRUE * factor, "motor_1.servo_damping": 2.0 * factor})


def record_of(robot: Robot) -> Record:
    """A log of the joint with its true gains, as of a real machine."""
    return replace(checked_log(servo_log(FRICTION), robot, name="log"), imported=True)


def driven(robot: Robot) -> RobotWithEffects:
    return driven_model(RobotWithEffects(robot, ()), record_of(robot))


@pytest.mark.parametrize("factor", [1.0, 30.0])
def test_the_weight_shows_the_stiffness_whatever_the_file_says(factor: float) -> None:
    robot = robot_with(factor)
    found = carrying_stiffness(record_of(robot), driven(robot), ServoStartSettings())
    np.testing.assert_allclose(found, TRUE, rtol=0.1)


@pytest.mark.parametrize("factor", [0.3, 1.0, 4.0])
def test_gains_that_the_search_reaches_are_left_to_it(factor: float) -> None:
    robot = robot_with(factor)
    assert rough_gains(record_of(robot), driven(robot), ServoStartSettings()) == ()


def test_gains_that_are_off_by_far_are_replaced() -> None:
    robot = robot_with(30.0)
    stiffness, damping = rough_gains(record_of(robot), driven(robot), ServoStartSettings())
    assert isinstance(stiffness.effect, ServoStiffnessError)
    assert isinstance(damping.effect, ServoDampingError)
    assert stiffness.effect.relative == pytest.approx(1 / 30 - 1, abs=0.01)
    assert damping.effect.relative == stiffness.effect.relative


def test_gravity_alone_fixes_the_scale_of_unknown_gains() -> None:
    stated = Tolerance(("gravity.z", "body_1.mass", "motor_1.servo_damping"), (0.03, 0.02, 0.03))
    assert scaled_by_gravity(stated) == Tolerance(("body_1.mass",), (0.02,))


def test_the_answer_is_relative_to_the_file() -> None:
    robot = robot_with(30.0)
    record = record_of(robot)
    result = diagnose(record, robot, settings=settings_of("coulomb_friction", "servo_stiffness_error"))
    patched = RobotWithEffects(robot, ()).with_effects(result.patch)
    assert patched.robot.parameters["motor_1.servo_stiffness"].value == pytest.approx(TRUE, rel=0.05)
    (stiffness,) = (one for one in result.diagnosis.causes if one.effect == "servo_stiffness_error")
    assert stiffness.parameters["relative"].value == pytest.approx(1 / 30 - 1, abs=0.003)
    (friction,) = (one for one in result.diagnosis.causes if one.effect == "coulomb_friction")
    assert friction.parameters["level"].value == pytest.approx(0.3, rel=0.1)
    (number,) = (one for one in result.diagnosis.model_numbers if one.name == "motor_1.servo_stiffness")
    assert number.nominal == pytest.approx(30 * TRUE)
    assert number.value == pytest.approx(TRUE, rel=0.05)
    assert any("motor_1.servo_stiffness" in text for text in result.diagnosis.warnings)


def test_a_gap_has_the_torques_of_likely_gains() -> None:
    robot, settings = robot_with(30.0), DiagnosisSettings()
    record, true = record_of(robot), record_of(robot_with(1.0))
    found = with_likely_gains(record, driven(robot), None, settings)
    np.testing.assert_allclose(np.std(found.torque), np.std(true.torque), rtol=0.1)
    none = settings.servo_start.model_copy(update={"least_carried": 0.999})
    unknown = settings.model_copy(update={"servo_start": none})
    assert with_likely_gains(record, driven(robot), None, unknown) is record
    repaired = with_likely_gains(record, driven(robot), driven(robot_with(1.0)), unknown)
    np.testing.assert_allclose(repaired.torque, true.torque)


def test_an_offset_of_the_positions_is_no_weak_servo() -> None:
    robot = robot_with(1.0)
    record = record_of(robot)
    offset = replace(record, position=record.position + 0.3)
    assert rough_gains(offset, driven(robot), ServoStartSettings())
    assert likely_gains(offset, driven(robot), DiagnosisSettings()) == ()
