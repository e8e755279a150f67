"""Arms and paths in a viser scene: shapes that are made once and moved with every instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.report.colours import FLOOR
from flexros.view.drawing import evenly, ribbon, turned_z

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.arm_view import ArmView
    from flexros.view.motion import Motion

_GHOST = 0.35
"""Opacity of the arm with stiff springs [1] (chosen)."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of a colour "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


class ArmShown:
    """One arm of the scene, and beside it the arm with stiff springs.

    Args:
        server: The page.
        name: Name in the scene, also its label.
        view: Bars of the robot.
        colour: Colour, "#rrggbb".
        arm: Arm coordinates over time, NaN where there are none [rad or m], shape (n, N).
        motion: Motion of the robot at the same instants.
        ghost: Whether the arm with stiff springs is drawn as well.
    """

    def __init__(
        self, server: Any, name: str, view: ArmView, colour: str, arm: FloatArray, motion: Motion, *, ghost: bool
    ) -> None:
        self._view, self._arm, self._motion, stiff = view, arm, motion, motion.stiff
        self.frame = server.scene.add_frame(f"/{name}", show_axes=False)
        self._lengths = np.linalg.norm(np.diff(view.at(stiff[:1])[0], axis=1)[:, 0], axis=1)
        self._bars = self._made(server, f"/{name}/bar", colour, 1.0)
        self._ghosts = self._made(server, f"/{name}/stiff", FLOOR, _GHOST) if ghost else []
        self.label = server.scene.add_label(f"/{name}/label", name)
        self._stiff_ends = view.at(stiff)
        self.magnify(1.0)

    def _made(self, server: Any, name: str, colour: str, opacity: float) -> list[tuple[Any, Any]]:
        made = []
        for index, (radius, length) in enumerate(zip(self._view.radii, self._lengths, strict=True)):
            looks = {
                "color": rgb(colour),
                "opacity": None if opacity == 1.0 else opacity,
                "cast_shadow": False,
            }
            bar = server.scene.add_cylinder(f"{name}_{index}", radius=radius, height=length, **looks)
            joint = server.scene.add_icosphere(f"{name}_{index}_joint", radius=1.35 * radius, **looks)
            made.append((bar, joint))
        return made

    def magnify(self, factor: float, error_factor: float = 1.0) -> None:
        """Magnify what is too small to be seen.

        Args:
            factor: Factor on the deflection of the robot, the difference of its arm coordinates to stiff springs.
            error_factor: Factor on the difference of this arm, a model, to the robot.
        """
        robot, stiff = self._motion.arm, self._motion.stiff
        self._ends = self._view.at(stiff + factor * (robot - stiff) + error_factor * (self._arm - robot))

    def show(self, row: int) -> None:
        """Move the shapes to one instant; before the first prediction of a model they are hidden."""
        there = bool(np.isfinite(self._ends[row]).all())
        for shapes, ends in ((self._bars, self._ends[row]), (self._ghosts, self._stiff_ends[row])):
            if not shapes:
                continue
            along = ends[:, 1] - ends[:, 0]
            turns = turned_z(np.nan_to_num(along, nan=1.0))
            for index, (bar, joint) in enumerate(shapes):
                bar.visible = joint.visible = there
                if not there:
                    continue
                bar.wxyz, bar.position = turns[index], ends[index].mean(axis=0)
                bar.scale = (1.0, 1.0, float(np.linalg.norm(along[index]) / max(self._lengths[index], 1e-9)))
                joint.position = ends[index, 0]

    @property
    def ends(self) -> FloatArray:
        """Ends of all bars at all instants, as drawn [m], shape (n, n_bars, 2, 3)."""
        return self._ends


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
