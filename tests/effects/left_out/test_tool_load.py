"""A load that the robot file leaves out."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved
from flexros.robot import load_robot
from tests.gap.servo_logs import servo_arm, servo_robot


def test_body_with_a_load_is_both_together() -> None:
    robot = load_robot("elbow")
    body = last_moved(robot)
    own, center, inertia = body_numbers(robot, body)
    place = np.array([0.1, 0.02, 0.3])
    loaded = ToolLoad(mass=2.0, x=0.1, y=0.02, z=0.3).changed(robot, "tool")
    mass, common, whole = body_numbers(loaded, body)
    assert mass == pytest.approx(own + 2.0)
    np.testing.assert_allclose(mass * common, own * center + 2.0 * place)
    shift, offset = center - common, place - common
    expected = inertia + own * (shift @ shift * np.eye(3) - np.outer(shift, shift))
    np.testing.assert_allclose(whole, expected + 2.0 * (offset @ offset * np.eye(3) - np.outer(offset, offset)))


def test_no_mass_changes_nothing() -> None:
    robot = load_robot("elbow")
    assert ToolLoad().changed(robot, "tool") is robot


def test_a_diagnosis_seeks_it_where_several_servos_carry_it() -> None:
    """Other logs have torques, which show it; what it does to a single servo, other gains do as well."""
    arm, joint = servo_arm(), servo_robot()
    assert ToolLoad().sought(arm.commanded_by("position"), "tool")
    assert not ToolLoad().sought(arm, "tool")
    assert not ToolLoad().sought(joint.commanded_by("position"), "tool")


def test_of_a_real_machine_it_is_sought_behind_springs() -> None:
    assert ToolLoad().sought_if_measured(load_robot("elbow"), "tool")
    assert not ToolLoad().sought_if_measured(servo_arm(), "tool")


def test_its_place_along_the_axis_of_all_joints_is_not_fitted() -> None:
    assert list(ToolLoad().fitted(servo_arm(), "tool")) == ["mass", "x", "z"]
    assert list(ToolLoad().fitted(load_robot("six_axis"), "tool")) == ["mass", "x", "y", "z"]
