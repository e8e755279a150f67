"""Robot files from a URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.urdf import skeleton_from_urdf

URDF = """<robot name="little">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.3" rpy="0 0 1.5707963267948966"/><mass value="12"/>
    <inertia ixx="0.5" iyy="0.4" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="7"/>
    <inertia ixx="0.1" iyy="0.3" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0 0.01 0"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="camera"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit effort="150" velocity="3" lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 0.6" rpy="0 1.5707963267948966 0"/><axis xyz="0 1 0"/>
    <limit effort="0" velocity="3" lower="-3" upper="3"/></joint>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="hand"/><origin xyz="0.4 0 0"/></joint>
  <joint name="eye" type="fixed"><parent link="upper"/><child link="camera"/></joint>
</robot>
"""


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    file = tmp_path / "little.urdf"
    file.write_text(URDF)
    return file


def test_skeleton_is_a_robot_file_with_the_dynamics_of_the_urdf(urdf: Path, tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
    robot_file = tmp_path / "little.yaml"
    robot_file.write_text(skeleton_from_urdf(urdf))
    robot = load_robot(robot_file)
    assert robot.n_arm == 2
    model = pin.buildModelFromXML(URDF)
    data = model.createData()
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=2), rng.normal(size=2), rng.normal(size=2)
    ours = np.asarray(robot.model.arm_inverse_dynamics(q, v, a, [])).ravel()
    np.testing.assert_allclose(ours, pin.rnea(model, data, q, v, a), rtol=1e-6)


def test_torque_limit_and_comment_are_written(urdf: Path) -> None:
    text = skeleton_from_urdf(urdf)
    assert "torque_limit: 150.0" in text
    assert "replace by the gear's stiffness" in text


def test_slanted_axis_is_named(urdf: Path) -> None:
    urdf.write_text(URDF.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 1"/>'))
    with pytest.raises(InputError, match="joint 'elbow' turns about"):
        skeleton_from_urdf(urdf)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not xml", "is not XML"),
        ("<sdf/>", "starts with <sdf>"),
        ("<robot name='a'><link name='b'/></robot>", "no revolute, continuous or prismatic joint"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>", "document type definition"),
    ],
)
def test_what_is_no_urdf_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "bad.urdf"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        skeleton_from_urdf(file)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read"):
        skeleton_from_urdf(tmp_path / "none.urdf")
