"""Shapes of a URDF on the bodies of the robot made from it, against those that Pinocchio places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf
from flexros.robot.exchange.urdf.visuals import BASE, mesh_path, visuals

INERTIAL = (
    '<inertial><mass value="1"/><origin xyz="0.1 0 0"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
URDF = f"""<robot name="arm">
<link name="base"><visual><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.2 0.2"/></geometry></visual></link>
<joint name="turn" type="revolute"><origin xyz="0 0.05 0.3" rpy="0.2 0 0"/><parent link="base"/><child link="column"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="column">{INERTIAL}<visual><origin xyz="0 0 0.2" rpy="0.1 0.2 0.3"/>
<geometry><cylinder radius="0.05" length="0.4"/></geometry></visual></link>
<joint name="lift" type="revolute"><origin xyz="0 0 0.4" rpy="1.2 0.3 0"/><parent link="column"/><child link="arm"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="arm">{INERTIAL}<visual><origin xyz="0.2 0 0"/>
<geometry><box size="0.4 0.05 0.06"/></geometry></visual></link>
<joint name="slide" type="prismatic"><origin xyz="0.4 0 0"/><parent link="arm"/><child link="hand"/>
<axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<link name="hand">{INERTIAL}<visual><geometry><sphere radius="0.07"/></geometry></visual></link>
<joint name="mount" type="fixed"><origin xyz="0.1 0 0.05" rpy="0 1 0"/><parent link="hand"/><child link="camera"/>
</joint>
<link name="camera"><visual><geometry><box size="0.02 0.03 0.04"/></geometry></visual></link>
</robot>"""


def robot_of(folder: Path, text: str = URDF, tip: str = "hand") -> Robot:
    urdf, file = folder / "model" / "arm.urdf", folder / "robots" / "arm.yaml"
    urdf.parent.mkdir()
    file.parent.mkdir()
    urdf.write_text(text)
    file.write_text(robot_from_urdf(urdf, tip, file.parent).text)
    return load_robot(file)


def test_shapes_are_where_pinocchio_places_them(tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio")
    robot = robot_of(tmp_path)
    model = pin.buildModelFromXML(URDF)
    geometry = pin.buildGeomFromUrdfString(model, URDF, pin.GeometryType.VISUAL)
    q = np.array([0.7, -0.4, 0.2])
    signs = [-1.0 if robot.spec.tags.get(f"motor_{k}.joint_sign") == "-1" else 1.0 for k in (1, 2, 3)]
    assert -1.0 in signs
    data, shown = model.createData(), geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, shown, q)
    origins, rotations = BodyPlacements(robot).at(np.array([np.multiply(signs, q)]))
    found = {}
    for one in visuals(robot):
        R = np.eye(3) if one.body == BASE else rotations[0, one.body]
        p = np.zeros(3) if one.body == BASE else origins[0, one.body]
        found[one.link] = (R @ one.rotation, p + R @ one.origin)
    assert set(found) == {"base", "column", "arm", "hand", "camera"}
    # the base of the robot file: at the first joint, turned because that is slanted
    turn = Rotation.from_euler("xyz", [0.2, 0, 0]).as_matrix().T
    for index, shape in enumerate(geometry.geometryObjects):
        R, p = found[shape.name.rpartition("_")[0]]
        placed = shown.oMg[index]
        np.testing.assert_allclose(p, turn @ (placed.translation - [0, 0.05, 0.3]), atol=1e-9)
        np.testing.assert_allclose(R, turn @ placed.rotation, atol=1e-9)


def test_changed_copies_keep_the_drawing_and_it_is_no_part_of_the_model(tmp_path: Path) -> None:
    robot = robot_of(tmp_path)
    plain = tmp_path / "plain.yaml"
    lines = (tmp_path / "robots" / "arm.yaml").read_text().splitlines(keepends=True)
    plain.write_text("".join(line for line in lines if not line.startswith("drawing:")))
    assert load_robot(plain).model_hash == robot.model_hash
    assert visuals(load_robot(plain)) == []
    assert len(visuals(robot.with_values({"body_1.mass": 2.0}, "test"))) == 5


def test_bodies_must_name_the_links(tmp_path: Path) -> None:
    robot_of(tmp_path)
    file = tmp_path / "robots" / "arm.yaml"
    file.write_text(file.read_text().replace("label: arm", "label: forearm"))
    with pytest.raises(InputError, match=r"labels column, forearm, hand; correct the labels"):
        visuals(load_robot(file))


def test_urdf_without_shapes_is_no_drawing(tmp_path: Path) -> None:
    import re

    robot = robot_of(tmp_path, re.sub(r"<visual>.*?</visual>", "", URDF, flags=re.DOTALL))
    assert robot.spec.drawing == ""


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("meshes/a.stl", "ws/arm_description/urdf/meshes/a.stl"),
        ("package://arm_description/meshes/b.stl", "ws/arm_description/meshes/b.stl"),
        ("package://other_description/c.stl", "elsewhere/other_description/c.stl"),
        ("package://arm_description/meshes/none.stl", None),
    ],
)
def test_meshes_are_found(name: str, expected: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for file in (
        "ws/arm_description/urdf/meshes/a.stl",
        "ws/arm_description/meshes/b.stl",
        "elsewhere/other_description/c.stl",
    ):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere"))
    found = mesh_path(name, tmp_path / "ws/arm_description/urdf/arm.urdf")
    assert found == (tmp_path / expected if expected else None)
