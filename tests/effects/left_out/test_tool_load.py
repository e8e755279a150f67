"""A load that the robot file leaves out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved, seen_axes
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY
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


@pytest.mark.parametrize(("turn", "seen"), [(0.0, "xz"), (np.pi, "xz"), (3.1416, "xz"), (np.pi / 2, "xyz")])
def test_axes_are_parallel_however_the_frames_of_their_bodies_are_turned(
    turn: float, seen: str, tmp_path: Path
) -> None:
    """An arm from a URDF has turned frames: about x by half a turn an axis along y stays parallel."""
    text = (LIBRARY / "elbow.yaml").read_text().replace("inverse_kinematics: two_link_elbow", "")
    label = "  - label: forearm, horizontal at zero angle\n"
    text = text.replace(label, f"{label}    orientation: [{turn}, 0, 0]\n")
    text = re.sub(r"inertia: {yy: (.*)}", r"inertia: {xx: \1, yy: \1, zz: \1}", text)
    (tmp_path / "turned.yaml").write_text(text.replace("controlled: tool", "controlled: joints"))
    assert seen_axes(load_robot(tmp_path / "turned.yaml"), "body_2") == tuple(seen)
