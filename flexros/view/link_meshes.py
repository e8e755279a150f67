"""Surfaces of the links of an arm whose robot file names a URDF as its drawing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import LARGEST_MESH
from flexros.robot.exchange.urdf.visuals import mesh_path, visuals

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.robot import Robot
    from flexros.robot.exchange.urdf.visuals import Visual

SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb", ".dae")
"""Kinds of mesh files that are read."""


@dataclass(frozen=True, eq=False)
class LinkMesh:
    """Surface of all that is fixed to a body, in its frame.

    Attributes:
        body: Index of the body; -1 for the base.
        corners: Corners [m], shape (n, 3).
        faces: Triangles of corners, shape (k, 3).
    """

    body: int
    corners: FloatArray
    faces: IntArray


@dataclass(frozen=True, eq=False)
class ArmDrawing:
    """What is drawn of an arm in place of bars.

    Attributes:
        meshes: One surface per body that has shapes; empty for bars.
        note: One sentence about what could not be drawn; empty for nothing.
    """

    meshes: tuple[LinkMesh, ...]
    note: str

    def grown(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Grow a box around the bars so that it holds the base.

        Args:
            low: Least coordinates [m], shape (3,).
            high: Largest coordinates [m], shape (3,).

        Returns:
            Both, with the base.
        """
        base = [mesh.corners for mesh in self.meshes if mesh.body < 0]
        points = np.concatenate([low[None], high[None], *base])
        return points.min(axis=0), points.max(axis=0)


def arm_drawing(robot: Robot) -> ArmDrawing:
    """Return the surfaces of the links of a robot.

    Args:
        robot: The robot.

    Returns:
        The surfaces. Without a drawing in the robot file, or where nothing of it can be read, there are none.
    """
    try:
        shapes = visuals(robot)
    except InputError as error:
        return ArmDrawing((), f"The arm is drawn as bars: {error}")
    made: dict[int, list[Any]] = {}
    missing: list[str] = []
    for shape in shapes:
        surface = _surface(shape, Path(robot.spec.drawing))
        if surface is None:
            missing.append(shape.file)
            continue
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = shape.rotation, shape.origin
        surface.apply_transform(pose)
        made.setdefault(shape.body, []).append(surface)
    note = _about(missing, robot.spec.drawing)
    if not any(body >= 0 for body in made):
        return ArmDrawing((), note and f"{note} The arm is drawn as bars.")
    return ArmDrawing(tuple(_joined(body, parts) for body, parts in sorted(made.items())), note)


def _about(missing: list[str], urdf: str) -> str:
    """Return the sentence about meshes that are left out."""
    if not missing:
        return ""
    names = list(dict.fromkeys(missing))
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return (
        f"Meshes of {Path(urdf).name} that cannot be read are left out: {names[0]}{more}; give their folder in "
        f"ROS_PACKAGE_PATH, in one of the formats {', '.join(SUFFIXES)}."
    )


def _surface(shape: Visual, urdf: Path) -> Any:
    """Return the `trimesh.Trimesh` of a shape in its own frame; None where its mesh cannot be read."""
    import trimesh

    if shape.kind == "box":
        return trimesh.creation.box(extents=shape.size)
    if shape.kind == "cylinder":
        return trimesh.creation.cylinder(radius=shape.size[0], height=shape.size[1], sections=40)
    if shape.kind == "sphere":
        return trimesh.creation.icosphere(radius=shape.size[0], subdivisions=3)
    path = mesh_path(shape.file, urdf)
    if path is None or path.suffix.lower() not in SUFFIXES or path.stat().st_size > LARGEST_MESH:
        return None
    try:
        surface = trimesh.load_scene(path).to_mesh()
        if not len(surface.faces):
            return None
        surface.apply_transform(np.diag([*shape.size, 1.0]))
    except Exception:  # noqa: BLE001 - damaged mesh files fail in many ways; the arm is drawn without them
        return None
    return surface


def _joined(body: int, parts: list[Any]) -> LinkMesh:
    import trimesh

    whole: Any = trimesh.util.concatenate(parts)
    return LinkMesh(body, np.asarray(whole.vertices, dtype=np.float64), np.asarray(whole.faces, dtype=np.int64))
