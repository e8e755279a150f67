"""The moving arm inside an offline report: a line through its bars, played and magnified by the page itself."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go

from flexros.logs.stamps import NANOSECONDS
from flexros.report.base import MovingLine, Paragraph, Picture
from flexros.report.colours import FLOOR, REPAIRED
from flexros.report.page import Chapter
from flexros.report.theme import REFERENCE, space
from flexros.robot.arm_view import ArmView
from flexros.view.drawing import evenly, magnification
from flexros.view.motion import robot_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.logs.time_series import Log

FRAMES = 160
"""Most instants in the page (chosen): about 100 kB with six bodies."""
LENGTH = 10.0
"""Length of the part that is played [s] (chosen)."""
_PLANE = 0.02
"""Largest extent across a plane, of the extent of the arm, of one that moves in the plane (chosen)."""
HEIGHT = 420
"""Height of the picture [px]."""


def motion_chapter(log: Log, model: RobotWithEffects, name: str, commanded: FloatArray | None = None) -> Chapter:
    """Return the chapter with the moving arm of a run.

    Args:
        log: The log; its first 10 s are played.
        model: Model of its robot.
        name: Name of the log, for messages.
        commanded: Commanded path of the tool, which is drawn too [m], shape (n, 3).

    Raises:
        InputError: The log has no motor positions of this robot.
    """
    motion = robot_motion(_beginning(log), model, name, length=LENGTH)
    rows = evenly(len(motion.time), FRAMES)
    view = ArmView(model.robot)
    stiff, arm = (_through(view.at(part[rows])) for part in (motion.stiff, motion.arm))
    deviation = arm - stiff
    extent = float(np.linalg.norm(np.ptp(stiff.reshape(-1, 3), axis=0))) or 1.0
    moved = float(np.max(np.linalg.norm(deviation, axis=-1)))
    factor = magnification(moved, extent) if moved > 0 else 1
    figure = space(HEIGHT)
    figure.add_trace(_line(stiff[0], "stiff springs, at the start", FLOOR, 5))
    figure.add_trace(_line(stiff[0] + factor * deviation[0], "arm", REPAIRED, 9))
    if commanded is not None:
        figure.add_trace(_line(commanded[evenly(len(commanded), FRAMES)], "commanded path", REFERENCE, 3))
    reach = np.concatenate([(stiff + factor * deviation).reshape(-1, 3), stiff.reshape(-1, 3)])
    for axis, low, high in zip("xyz", reach.min(axis=0), reach.max(axis=0), strict=True):
        room = 0.08 * extent
        figure.update_layout({f"scene.{axis}axis.range": [float(low - room), float(high + room)]})
    played = "" if motion.time[-1] < LENGTH - 0.1 else f" The first {LENGTH:g} s are played."
    if np.ptp(reach[:, 1]) < _PLANE * extent:  # an arm that moves upright is seen from its side
        figure.update_layout(
            scene_camera={"eye": {"x": 0.0, "y": -1.6, "z": 0.0}, "projection": {"type": "orthographic"}},
            scene_yaxis_visible=False,
        )
    caption = f"The arm, its deflection drawn ×{{factor}}.{played} Turn it with the mouse."
    moving = MovingLine(1, motion.time[rows], stiff, deviation)
    return Chapter("The arm in motion", (Picture(figure, caption, (), factor, moving), Paragraph(motion.note, "note")))


def _beginning(log: Log) -> Log:
    """Return the joints of the part that is played, and a second more."""
    end = log.joint_states.stamp[0] + round((LENGTH + 1.0) * NANOSECONDS)
    joints = (None if one is None else one.until(end) for one in (log.joint_commands, log.joint_reference))
    commands, reference = joints
    return replace(
        log,
        joint_states=log.joint_states.until(end),
        joint_commands=commands,
        joint_reference=reference,
        tool_pose=None,
        tool_reference=None,
    )


def _through(ends: FloatArray) -> FloatArray:
    """Return the points of a line through all bars, shape (n, n_bars + 1, 3); bars apart are joined by the line."""
    return np.concatenate([ends[:, :, 0], ends[:, -1:, 1]], axis=1)


def _line(points: FloatArray, name: str, colour: str, width: int) -> go.Scatter3d:
    x, y, z = np.round(points, 4).T.tolist()
    mode = "lines+markers" if width > 4 else "lines"
    return go.Scatter3d(
        x=x, y=y, z=z, name=name, mode=mode, line={"color": colour, "width": width},
        marker={"color": colour, "size": 0.5 * width}, hoverinfo="skip",
    )  # fmt: skip
