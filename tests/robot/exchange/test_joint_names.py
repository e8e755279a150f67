"""Joints of an imported file as motors."""

from __future__ import annotations

from flexros.robot import Robot, load_robot
from flexros.robot.exchange.joint_names import joints_line


def tagged(**tags: str) -> Robot:
    spec = load_robot("elbow").spec
    named = {key.replace("__", "."): value for key, value in tags.items()}
    return Robot(spec.model_copy(update={"tags": named}), "arm.yaml")


def test_joints_of_motors_are_told_with_those_that_count_the_other_way_round() -> None:
    robot = tagged(motor_1__joint="pan", motor_2__joint="lift", motor_2__joint_sign="-1")
    assert joints_line(robot) == "Joints: motor_1 = pan, motor_2 = lift; lift counts the other way round"


def test_a_robot_that_was_not_imported_has_no_other_names() -> None:
    assert joints_line(load_robot("elbow")) == ""
