"""True tool pose of a blind plant, and the share of a kinematic error that a tracker can observe."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation

ALIGNMENTS = 5
"""Alternations between the frame of the tracker and the offset of its target (chosen)."""


def seen_pose(
    robot: Robot, deviations: Sequence[Deviation], states: FloatArray, bent: Robot | None = None
) -> FloatArray:
    """Compute tool poses.

    Args:
        robot: The robot without deviations.
        deviations: What is hidden; errors of kinematics act here.
        states: States of the simulated robot, shape (n, 2 n_coordinates of that robot).
        bent: The simulated robot, where a body was added; `robot` when None.

    Returns:
        Position [m] and quaternion xyzw, shape (n, 7).
    """
    body_below = any(one.effect == "extra_mode" and one.location == "base" for one in deviations)
    used = bent if body_below and bent is not None else robot
    changed = {}
    for one in deviations:
        if one.effect == "kinematic_error":
            number = int(one.location.removeprefix("body_")) + body_below
            changed.update(_longer(used, number, one.parameters["length"]))
    model = used.with_values(changed).model
    q = ca.SX.sym("q", used.n_arm)
    pose = ca.Function("pose", [q], [ca.densify(model.tool_pose(q, model.parameter_values))])
    return np.asarray(pose(states[:, : used.n_arm].T)).T


def _longer(robot: Robot, number: int, length: float) -> dict[str, float]:
    """Change the length of a body along its longest direction."""
    vector = np.array(robot.spec.bodies[number - 1].length.value)
    axis = "xyz"[int(np.argmax(np.abs(vector)))]
    name = f"body_{number}.length.{axis}"
    return {name: robot.parameters[name].value + length}


def tool_gain(nominal: FloatArray, true: FloatArray, noise: float) -> float:
    """Compute what of an error of kinematics remains once frame, offset and time of the tracker are fitted.

    Args:
        nominal: Poses by the nominal kinematics, shape (n, 7).
        true: Poses as they are, shape (n, 7).
        noise: Noise of the tracker [m].

    Returns:
        Half the sum of squared residuals over the variance of the noise [nats].
    """
    turn = Rotation.from_quat(nominal[:, 3:]).as_matrix()
    offset, target = np.zeros(3), true[:, :3]
    for _ in range(ALIGNMENTS):
        points = nominal[:, :3] + turn @ offset
        here, there = points - points.mean(axis=0), target - target.mean(axis=0)
        frame, _ = Rotation.align_vectors(there, here)
        back = frame.inv().apply(there)
        slope = (turn - turn.mean(axis=0)).reshape(-1, 3)
        rest = (back - (nominal[:, :3] - nominal[:, :3].mean(axis=0))).ravel()
        offset = np.linalg.lstsq(slope, rest, rcond=None)[0]
    points = nominal[:, :3] + turn @ offset
    here, there = points - points.mean(axis=0), target - target.mean(axis=0)
    frame, _ = Rotation.align_vectors(there, here)
    seen = frame.apply(here)
    turns = [np.cross(axis, seen) for axis in np.eye(3)]
    shifts = [np.broadcast_to(axis, seen.shape) for axis in np.eye(3)]
    offsets = [frame.apply(turn[:, :, column]) for column in range(3)]
    unknown = np.stack([*turns, *shifts, *offsets, np.gradient(seen, axis=0)], axis=-1).reshape(seen.size, -1)
    error = (there - seen).ravel()
    error = error - unknown @ np.linalg.lstsq(unknown, error, rcond=1e-9)[0]
    return float(error @ error) / (2 * noise**2)
