"""Why static linearisation yields to a load: its measured acceleration is that of a robot without the load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.robot import Robot


def sag_of_static_linearisation(robot: Robot, pose: Sequence[float], force: float, bandwidth: float) -> float:
    """Predict how far static linearisation lets the tool sag under a force along z, exactly at rest.

        a = M^-1 J^T F,   q_r - q = (6 / w^2 - M^-1 K / w^4) a

    The law takes the acceleration of the links from the torques of the gears. Under a load e = J^T F these torques hold
    the load at rest, but the law reads from them the acceleration a of a free link, and v = w^4 (q_r - q) - 6 w^2 a
    balances it in the equation of the motors, 0 = a + K^-1 M v.

    Args:
        robot: A robot of flexible joints.
        pose: Arm coordinates [rad], length N.
        force: Force at the tool along z [N].
        bandwidth: Bandwidth w of the law [rad/s].

    Returns:
        Distance of the tool from its place [mm].
    """
    arm = np.asarray(pose, dtype=float)
    slopes = []
    for number in range(len(arm)):
        step = 1e-6 * np.eye(len(arm))[number]
        slopes.append((_tool(robot, arm + step) - _tool(robot, arm - step)) / 2e-6)
    J = np.column_stack(slopes)
    M = np.asarray(robot.model.arm_inertia(arm, []), dtype=float)
    K = np.diag([robot.parameters[f"{robot.joints[row].name}.stiffness"].value for row in robot.gear_rows])
    a = np.linalg.solve(M, J.T @ np.array([0.0, force]))
    moved = 6.0 * a / bandwidth**2 - np.linalg.solve(M, K @ a) / bandwidth**4
    return 1e3 * float(np.linalg.norm(J @ moved))


def _tool(
    robot: Robot, arm: np.ndarray[tuple[int, ...], np.dtype[np.float64]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the position of the tool in the plane x-z [m], shape (2,)."""
    pose = np.asarray(robot.model.tool_pose(arm, []), dtype=float).ravel()
    return np.asarray(pose[[0, 2]])
