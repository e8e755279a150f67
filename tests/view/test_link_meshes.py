from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.robot import Robot, load_robot
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf
from flexros.view.link_meshes import arm_drawing

trimesh = pytest.importorskip("trimesh", reason="the viewer is not installed: pip install 'flexros[view]'")

URDF = """<robot name="arm">
<link name="base"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="arm"><inertial><mass value="1"/><origin xyz="0.2 0 0"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0.5 0 0"/><geometry>{shape}</geometry></visual>
<visual><geometry><sphere radius="0.05"/></geometry></visual></link>
</robot>"""


def robot_with(shape: str, folder: Path) -> Robot:
    (folder / "arm.urdf").write_text(URDF.format(shape=shape))
    (folder / "arm.yaml").write_text(robot_from_urdf(folder / "arm.urdf", folder=folder).text)
    return load_robot(folder / "arm.yaml")


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ('<box size="0.4 0.2 0.1"/>', (0.2, 0.1, 0.05)),
        ('<cylinder radius="0.1" length="0.6"/>', (0.1, 0.1, 0.3)),
        ('<sphere radius="0.2"/>', (0.2, 0.2, 0.2)),
        ('<mesh filename="part.stl" scale="0.001 0.001 0.002"/>', (0.1, 0.2, 0.6)),
        ('<mesh filename="part.dae" scale="0.001 0.001 0.002"/>', (0.1, 0.2, 0.6)),
    ],
)
def test_shapes_have_their_size_and_place(shape: str, half: tuple[float, ...], tmp_path: Path) -> None:
    for name in ("part.stl", "part.dae"):
        trimesh.creation.box(extents=(200, 400, 600)).export(tmp_path / name)
    drawing = arm_drawing(robot_with(shape, tmp_path))
    assert drawing.note == ""
    (mesh,) = drawing.meshes
    assert mesh.body == 0
    outer = mesh.corners[np.linalg.norm(mesh.corners, axis=1) > 0.0501]  # without the ball about the origin
    np.testing.assert_allclose(outer.max(axis=0), np.array([0.5, 0, 0]) + half, atol=2e-3)
    np.testing.assert_allclose(outer.min(axis=0)[0], 0.5 - half[0], atol=2e-3)
    assert mesh.faces.max() == len(mesh.corners) - 1


@pytest.mark.parametrize("content", [None, b"solid nonsense"])
def test_mesh_that_cannot_be_read_is_left_out_with_a_sentence(content: bytes | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "part.stl").write_bytes(content)
    drawing = arm_drawing(robot_with('<mesh filename="part.stl"/>', tmp_path))
    assert "Meshes of arm.urdf that cannot be read are left out: part.stl; give" in drawing.note
    (mesh,) = drawing.meshes
    np.testing.assert_allclose(np.abs(mesh.corners).max(), 0.05, rtol=1e-6)


def test_missing_urdf_leaves_bars(tmp_path: Path) -> None:
    robot = robot_with('<box size="1 1 1"/>', tmp_path)
    (tmp_path / "arm.urdf").unlink()
    drawing = arm_drawing(robot)
    assert drawing.meshes == ()
    assert drawing.note.startswith("The arm is drawn as bars: ")


def test_robot_file_without_drawing_has_bars() -> None:
    assert arm_drawing(load_robot("e12")).meshes == ()
