"""Robots as URDF: Pinocchio reads from it the kinematics and dynamics that we have."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from flexros.robot import Robot, load_robot, robot_from_data, robot_names
from flexros.robot.exchange.urdf.export import Flexible, urdf_text
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

pytestmark = pytest.mark.slow

ROBOTS = robot_names()


@pytest.fixture
def pin() -> Any:
    return pytest.importorskip("pinocchio", reason="Pinocchio is not installed")


class FromUrdf:
    """Pinocchio's model of a URDF, with joints by name and angles instead of cosine and sine."""

    def __init__(self, pin: Any, text: str) -> None:
        self._pin = pin
        self.model = pin.buildModelFromXML(text)
        self.data = self.model.createData()
        self.names = list(self.model.names)[1:]

    def configuration(self, values: dict[str, float]) -> Any:
        q = self._pin.neutral(self.model)
        v = np.array([values[name] for name in self.names])
        return self._pin.integrate(self.model, q, v)

    def inertia(self, values: dict[str, float]) -> Any:
        upper = np.triu(self._pin.crba(self.model, self.data, self.configuration(values)))
        return upper + np.triu(upper, 1).T

    def tool(self, values: dict[str, float]) -> Any:
        self._pin.framesForwardKinematics(self.model, self.data, self.configuration(values))
        placement = self.data.oMf[self.model.getFrameId("tool")]
        return placement.translation, placement.rotation


def rotation_of(quaternion: Any) -> Any:
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def joints(robot: Robot, flexible: Flexible, seed: int) -> tuple[dict[str, float], Any, Any]:
    """Draw joint positions of the URDF by name; give the arm coordinates that they mean, and their slope."""
    rng = np.random.default_rng(seed)
    values: dict[str, float] = {}
    slope = []
    for index, joint in enumerate(robot.joints):
        if joint.mode is not None:  # links are straight in a URDF
            continue
        parts = [f"motor_{joint.motor + 1}"] if joint.motor is not None else []
        if flexible == "continuous" and (joint.motor is None or joint.motor_coordinate is not None):
            parts.append(joint.name)
        for name in parts:
            values[name] = float(rng.uniform(-1.5, 1.5))
            slope.append(np.eye(robot.n_arm)[index])
    matrix = np.array(slope).T
    return values, matrix @ np.array(list(values.values())), matrix


@pytest.mark.parametrize("flexible", ["fixed", "continuous"])
@pytest.mark.parametrize("name", ROBOTS)
def test_tool_and_inertia_are_ours_at_any_pose(pin: Any, name: str, flexible: Flexible) -> None:
    robot = load_robot(name)
    read = FromUrdf(pin, urdf_text(robot, flexible))
    for seed in range(5):
        values, q_a, slope = joints(robot, flexible, seed)
        assert read.names == list(values)
        M_a = np.asarray(robot.model.arm_inertia(q_a, robot.model.parameter_values))
        np.testing.assert_allclose(read.inertia(values), slope.T @ M_a @ slope, atol=1e-9 * np.max(M_a))
        if robot.spec.tool.linear is None:
            pose = robot.tool_pose(q_a)
            position, rotation = read.tool(values)
            np.testing.assert_allclose(position, pose[:3], atol=1e-12)
            np.testing.assert_allclose(rotation, rotation_of(pose[3:]), atol=1e-12)


def test_gravity_torques_are_ours(pin: Any) -> None:
    robot = load_robot("six_axis")
    read = FromUrdf(pin, urdf_text(robot, "continuous"))
    values, q_a, slope = joints(robot, "continuous", 0)
    zero = np.zeros(robot.n_arm)
    ours = slope.T @ np.asarray(robot.model.arm_inverse_dynamics(q_a, zero, zero, [])).ravel()
    theirs = pin.computeGeneralizedGravity(read.model, read.data, read.configuration(values))
    np.testing.assert_allclose(theirs, ours, atol=1e-9 * np.max(np.abs(ours)))


def test_four_mass_is_a_chain_of_joints_about_z() -> None:
    root = ElementTree.fromstring(urdf_text(load_robot("four_mass"), "continuous"))
    moving = [joint for joint in root.findall("joint") if joint.get("type") == "continuous"]
    assert [joint.get("name") for joint in moving] == ["motor_1", "body_1.rz", "body_2.rz", "body_3.rz"]
    assert {joint.find("axis").get("xyz") for joint in moving} == {"0 0 1"}  # type: ignore[union-attr]
    assert moving[0].find("limit").get("effort") == "20"  # type: ignore[union-attr]


@pytest.mark.parametrize("flexible", ["fixed", "continuous"])
@pytest.mark.parametrize("name", ROBOTS)
def test_links_form_one_chain_from_base_to_tool(name: str, flexible: Flexible) -> None:
    robot = load_robot(name)
    root = ElementTree.fromstring(urdf_text(robot, flexible))
    links = [link.get("name") for link in root.findall("link")]
    assert len(set(links)) == len(links)
    ends = [(joint.find("parent").get("link"), joint.find("child").get("link")) for joint in root.findall("joint")]  # type: ignore[union-attr]
    assert ends == list(pairwise(links))
    assert set(robot.joint_names) <= {joint.get("name") for joint in root.findall("joint")}
    assert any(link.find("visual") is not None for link in root.findall("link"))


@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_are_without_round_off(name: str) -> None:
    root = ElementTree.fromstring(urdf_text(load_robot(name)))
    texts = [part for element in root.iter() for value in element.attrib.values() for part in value.split()]
    numbers = [text for text in texts if re.fullmatch(r"-?[\d.]+(e[-+]\d+)?", text)]
    assert all(float(text) == float(f"{float(text):.13g}") for text in numbers)


def test_zero_of_an_attribute_has_no_sign() -> None:
    data = load_robot("elbow").spec.model_dump()
    data["bodies"][0]["center_of_mass"]["value"] = [-0.0, 0.0, 0.3]
    assert "-0 " not in urdf_text(robot_from_data(data, "elbow"))


def test_bar_of_a_body_points_along_its_length(pin: Any) -> None:
    """Lower arm upright, upper arm forward: the cylinders' z axes are turned there."""
    root = ElementTree.fromstring(urdf_text(load_robot("elbow")))
    for name, along, half in (("body_1", [0, 0, 1], [0, 0, 0.45]), ("body_2", [1, 0, 0], [0.4, 0, 0])):
        origin = root.find(f"link[@name='{name}']/visual/origin")
        assert origin is not None
        roll, pitch, yaw = (float(part) for part in origin.get("rpy", "").split())
        turned = pin.rpy.rpyToMatrix(roll, pitch, yaw) @ [0, 0, 1]
        np.testing.assert_allclose(turned, along, atol=1e-12)
        np.testing.assert_allclose([float(part) for part in origin.get("xyz", "").split()], half, atol=1e-12)


def test_what_is_written_can_be_read_as_a_robot_file_again(tmp_path: Path) -> None:
    file = tmp_path / "elbow.urdf"
    data = load_robot("elbow").spec.model_dump()
    data["bodies"][1]["directions"]["ry"]["motor"]["speed_limit"] = 2.5
    robot = robot_from_data(data, "elbow")
    file.write_text(urdf_text(robot))
    (tmp_path / "elbow.yaml").write_text(robot_from_urdf(file).text)
    again = load_robot(tmp_path / "elbow.yaml")
    pose = [0.3, -0.4]
    np.testing.assert_allclose(again.tool_pose(pose), robot.tool_pose(pose), atol=1e-9)
    assert list(again.torque_limits) == [3000, 2000]
    assert list(again.speed_limits) == [np.inf, 2.5]
