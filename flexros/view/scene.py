"""Arms and paths in a viser scene: shapes that are made once and moved with every instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.report.colours import FLOOR
from flexros.robot.arm_view import ArmView
from flexros.robot.body_placement import BodyPlacements
from flexros.view.drawing import evenly, ribbon, turned_z
from flexros.view.link_meshes import arm_drawing

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.robot import Robot
    from flexros.view.motion import Motion

GHOST = 0.35
"""Opacity of the arm with stiff springs [1] (chosen)."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of a colour "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


class ArmLook:
    """What a robot looks like: bars, or the surfaces of its links where its file names a drawing.

    Args:
        robot: The robot.

    Attributes:
        view: Its bars.
        drawing: Its surfaces.
        placements: Poses of its bodies.
    """

    def __init__(self, robot: Robot) -> None:
        self.view, self.drawing, self.placements = ArmView(robot), arm_drawing(robot), BodyPlacements(robot)

    def made(self, server: Any, name: str, colour: str, opacity: float = 1.0) -> AbstractShapes:
        """Draw the robot.

        Args:
            server: The page.
            name: Name in the scene.
            colour: Colour, "#rrggbb".
            opacity: Opacity [1].

        Returns:
            The shapes, not yet placed.
        """
        looks = {"color": rgb(colour), "opacity": None if opacity == 1.0 else opacity, "cast_shadow": False}
        return Links(server, name, self, looks) if self.drawing.meshes else Bars(server, name, self, looks)


class AbstractShapes(ABC):
    """Shapes of one arm, moved by its arm coordinates."""

    def move(self, arm: FloatArray) -> None:
        """Take over a motion.

        Args:
            arm: Arm coordinates [rad or m], NaN where there are none, shape (n, N).
        """
        self._there: BoolArray = np.all(np.isfinite(arm), axis=1)
        self._take(np.nan_to_num(arm))

    def show(self, row: int) -> None:
        """Place the shapes as in one instant of the motion; where there are no coordinates they are hidden."""
        there = bool(self._there[row])
        for shape in self._shapes():
            shape.visible = there
        if there:
            self._place(row)

    @abstractmethod
    def _take(self, arm: FloatArray) -> None: ...

    @abstractmethod
    def _place(self, row: int) -> None: ...

    @abstractmethod
    def _shapes(self) -> list[Any]: ...


class Bars(AbstractShapes):
    """Bars along the lengths of the robot file, with balls at the joints."""

    def __init__(self, server: Any, name: str, look: ArmLook, looks: dict[str, Any]) -> None:
        self._view, scene = look.view, server.scene
        self._bars = [
            scene.add_cylinder(f"{name}/bar_{index}", radius=radius, height=1.0, **looks)
            for index, radius in enumerate(look.view.radii)
        ]
        self._joints = [
            scene.add_icosphere(f"{name}/bar_{index}_joint", radius=1.35 * radius, **looks)
            for index, radius in enumerate(look.view.radii)
        ]

    def _take(self, arm: FloatArray) -> None:
        self._ends = self._view.at(arm)

    def _place(self, row: int) -> None:
        ends = self._ends[row]
        along = ends[:, 1] - ends[:, 0]
        turns = turned_z(along)
        for index, (bar, joint) in enumerate(zip(self._bars, self._joints, strict=True)):
            bar.wxyz, bar.position = turns[index], ends[index].mean(axis=0)
            bar.scale = (1.0, 1.0, max(float(np.linalg.norm(along[index])), 1e-9))
            joint.position = ends[index, 0]

    def _shapes(self) -> list[Any]:
        return [*self._bars, *self._joints]


class Links(AbstractShapes):
    """Surfaces of the links, that of the base at rest."""

    def __init__(self, server: Any, name: str, look: ArmLook, looks: dict[str, Any]) -> None:
        self._placements = look.placements
        self._meshes = [
            (mesh.body, server.scene.add_mesh_simple(f"{name}/link_{mesh.body + 1}", mesh.corners, mesh.faces, **looks))
            for mesh in look.drawing.meshes
        ]

    def _take(self, arm: FloatArray) -> None:
        self._origins, rotations = self._placements.at(arm)
        turns = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_quat()[:, [3, 0, 1, 2]]
        self._turns = turns.reshape(*rotations.shape[:2], 4)

    def _place(self, row: int) -> None:
        for body, mesh in self._meshes:
            if body >= 0:
                mesh.wxyz, mesh.position = self._turns[row, body], self._origins[row, body]

    def _shapes(self) -> list[Any]:
        return [mesh for _, mesh in self._meshes]


class ArmShown:
    """One arm of the scene, and beside it the arm with stiff springs.

    Args:
        server: The page.
        name: Name in the scene, also its label.
        look: What the robot looks like.
        colour: Colour, "#rrggbb".
        arm: Arm coordinates over time, NaN where there are none [rad or m], shape (n, N).
        motion: Motion of the robot at the same instants.
        ghost: Whether the arm with stiff springs is drawn as well.
    """

    def __init__(
        self, server: Any, name: str, look: ArmLook, colour: str, arm: FloatArray, motion: Motion, *, ghost: bool
    ) -> None:
        self._look, self._arm, self._motion = look, arm, motion
        self.frame = server.scene.add_frame(f"/{name}", show_axes=False)
        self._shapes = look.made(server, f"/{name}/arm", colour)
        self._ghost = look.made(server, f"/{name}/stiff", FLOOR, GHOST) if ghost else None
        if self._ghost is not None:
            self._ghost.move(motion.stiff)
        self.label = server.scene.add_label(f"/{name}/label", name)
        self.magnify(1.0)

    def magnify(self, factor: float, error_factor: float = 1.0) -> None:
        """Magnify what is too small to be seen.

        Args:
            factor: Factor on the deflection of the robot, the difference of its arm coordinates to stiff springs.
            error_factor: Factor on the difference of this arm, a model, to the robot.
        """
        robot, stiff = self._motion.arm, self._motion.stiff
        self._drawn = stiff + factor * (robot - stiff) + error_factor * (self._arm - robot)
        self._shapes.move(self._drawn)

    def show(self, row: int) -> None:
        """Move the shapes to one instant; before the first prediction of a model they are hidden."""
        self._shapes.show(row)
        if self._ghost is not None:
            self._ghost.show(row)

    @property
    def ends(self) -> FloatArray:
        """Ends of all bars at all instants, as drawn [m], shape (n, n_bars, 2, 3)."""
        return self._look.view.at(self._drawn)


@dataclass(frozen=True, eq=False)
class PathShown:
    """Path of the tool with its error.

    Attributes:
        time: Instants since the beginning of the log [s], shape (n,).
        commanded: Nearest points of the commanded path [m], shape (n, 3).
        deviation: Attained minus nearest point [m], shape (n, 3).
    """

    time: FloatArray
    commanded: FloatArray
    deviation: FloatArray

    def draw(self, server: Any, name: str, factor: float, colour: str) -> Any:
        """Draw the commanded path and the ribbon of its magnified error, in place of those of the same name.

        Args:
            server: The page.
            name: Name in the scene.
            factor: Magnification of the error.
            colour: Colour of the ribbon.

        Returns:
            The ribbon.
        """
        rows = evenly(len(self.time))
        base = self.commanded[rows]
        width = 0.006 * float(np.linalg.norm(np.ptp(base, axis=0)))
        corners, faces = ribbon(base, self.deviation[rows], factor)
        server.scene.add_line_segments(
            f"{name}/commanded", np.stack([base[:-1], base[1:]], axis=1), (27, 31, 36), thickness=width
        )
        edge = corners[len(rows) :]
        server.scene.add_line_segments(
            f"{name}/attained", np.stack([edge[:-1], edge[1:]], axis=1), rgb(colour), thickness=width
        )
        return server.scene.add_mesh_simple(
            f"{name}/error", corners, faces, color=rgb(colour), opacity=0.75, side="double", flat_shading=True,
            cast_shadow=False,
        )  # fmt: skip
