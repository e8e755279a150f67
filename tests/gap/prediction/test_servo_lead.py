"""Predictions of logs with position commands only."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.prediction.predictor import Predictor
from flexros.prediction.observer import observer_gain
from flexros.record.read import read_record
from flexros.robot import Robot
from tests.gap.servo_logs import NOISE, T, servo_log, servo_robot


def errors(robot: Robot, feedforward: float, *effects: str) -> np.ndarray:
    """Prediction errors of the nominal model in a log without noise, with a low gain."""
    record = read_record(servo_log(*effects, feedforward=feedforward, noise=0.0), robot, name="log", positions=True)
    driven = robot.commanded_by("position")
    predictor = Predictor(RobotWithEffects(driven, ()), (), Tolerance(), T)
    gain = observer_gain(driven, T, 1e-3, np.array([NOISE]))
    start = driven.equilibrium(motor_position=record.position[0])
    return predictor.predict(np.zeros((0, 1)), record, gain, start).innovation[:, 0, 0]


@pytest.mark.parametrize("feedforward", [0.0, 1.0])
def test_a_log_of_the_model_is_predicted_exactly(feedforward: float) -> None:
    assert np.abs(errors(servo_robot(feedforward), feedforward)).max() < 1e-8


def test_a_wrong_stiffness_or_feedforward_shows() -> None:
    assert np.abs(errors(servo_robot(), 0.0, "servo_stiffness_error@motor_1:relative=0.2")).max() > 1e-5
    assert np.abs(errors(servo_robot(0.0), 1.0)).max() > 1e-5


def test_tolerances_of_gains_count_where_positions_are_commanded() -> None:
    data = servo_robot().spec.model_dump()
    data["bodies"][0]["directions"]["ry"]["motor"]["servo"]["stiffness"]["tolerance"] = 0.2
    robot = Robot(type(servo_robot().spec).model_validate(data), "test")
    assert tolerance_of(robot, {}).names == ()
    assert tolerance_of(robot.commanded_by("position"), {}).names == ("motor_1.servo_stiffness",)
