"""Motors of robots: rotary or prismatic, behind flexible or rigid gears."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.robot import load_robot, robot_from_data, robot_names


@pytest.mark.parametrize(
    ("name", "rotary", "units"), [("e12", True, ("rad", "Nm", "Nm s/rad")), ("emps", False, ("m", "N", "N s/m"))]
)
def test_units_are_those_of_the_joint(name: str, rotary: bool, units: tuple[str, ...]) -> None:
    motor = load_robot(name).motors[0]
    assert motor.rotary is rotary
    assert (motor.position_unit, motor.torque_unit, motor.unit("damping")) == units


@pytest.mark.parametrize("name", robot_names())
def test_motors_agree_with_the_arrays_of_the_robot(name: str) -> None:
    robot = load_robot(name)
    assert tuple(motor.name for motor in robot.motors) == robot.joint_names
    assert tuple(motor.row for motor in robot.motors) == robot.motor_rows
    assert tuple(motor.gear_row for motor in robot.motors) == robot.gear_rows
    assert tuple(motor.index for motor in robot.motors if motor.flexible) == robot.flexible_motors
    assert [motor.joint for motor in robot.motors] == [robot.joints[row] for row in robot.gear_rows]
    np.testing.assert_array_equal([motor.torque_limit for motor in robot.motors], robot.torque_limits)


def test_motor_without_limit_has_an_infinite_one() -> None:
    assert load_robot("two_mass").motors[0].torque_limit == np.inf


def test_ratings_are_those_of_the_robot_file() -> None:
    motor = load_robot("elbow").motors[1]
    assert (motor.gear_ratio, motor.inertia, motor.torque_limit) == (100, 25, 2000)
    assert motor.speed_limit == np.inf


def test_speed_limit_of_the_file_leaves_the_fingerprint_of_robots_without_one() -> None:
    plain = load_robot("elbow")
    data = plain.spec.model_dump()
    motor = data["bodies"][0]["directions"]["ry"]["motor"]
    assert "speed_limit" not in motor
    motor["speed_limit"] = 2.5
    limited = robot_from_data(data, "elbow")
    np.testing.assert_array_equal(limited.speed_limits, [2.5, np.inf])
    assert limited.model_hash != plain.model_hash
