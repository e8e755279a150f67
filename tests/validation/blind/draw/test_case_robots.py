"""Robots of the blind check."""

from __future__ import annotations

from flexros.robot import load_robot
from flexros.validation.blind.draw.case_robots import case_robot, robot_source


def test_the_rigid_arm_has_six_motors_and_no_spring() -> None:
    robot = case_robot("rigid_six_axis")
    assert robot.n_motors == 6
    assert robot.n_coordinates == 6
    assert not robot.spring_rows


def test_shipped_robots_keep_their_name() -> None:
    assert robot_source("e12") == "e12"
    assert case_robot("e12").n_coordinates == load_robot("e12").n_coordinates
