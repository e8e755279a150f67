"""Poses of the bodies of a robot in the base frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.robot.symbolic.body_frame import body_frame

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot


def body_placement(robot: Robot, body: int, q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the frame of a body, with its origin at the end of the body before.

    Args:
        robot: The robot.
        body: Index of the body.
        q: Arm coordinates, SX (N, 1).

    Returns:
        Origin in the base frame [m], SX (3, 1), and rotation from the body to the base, SX (3, 3).
    """
    bodies = robot.spec.bodies
    if body < robot.joints[0].body:  # fixed to the ground
        below = (np.array(entry.length.value, dtype=float) for entry in bodies[:body])
        return ca.SX(ca.DM(sum(below, start=np.zeros(3)))), ca.SX.eye(3)
    values = {name: parameter.value for name, parameter in robot.parameters.items()}
    frame = body_frame(robot, body, q, values.__getitem__)
    return frame.center - frame.rotation @ ca.DM(bodies[body].center_of_mass.value), frame.rotation


class BodyPlacements:
    """Computes the poses of all bodies of a robot.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._n_arm = robot.n_arm
        self._n_bodies = len(robot.spec.bodies)
        q = ca.SX.sym("q", robot.n_arm)
        columns = [ca.horzcat(*body_placement(robot, body, q)) for body in range(self._n_bodies)]
        self._placements = ca.Function("placements", [q], [ca.densify(ca.horzcat(*columns))])

    def poses(self, state: FloatArray) -> FloatArray:
        """Return the poses in a state.

        Args:
            state: State that begins with the arm coordinates [rad or m], shape (n,).

        Returns:
            Position x, y, z [m] and quaternion x, y, z, w of each body in the base frame, shape (n_bodies, 7).
        """
        from scipy.spatial.transform import Rotation

        origins, rotations = self.at(state[None, : self._n_arm])
        return np.hstack([origins[0], Rotation.from_matrix(rotations[0]).as_quat()])

    def at(self, arm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the poses for arm coordinates.

        Args:
            arm: Arm coordinates [rad or m], shape (n, N).

        Returns:
            Origins in the base frame [m], shape (n, n_bodies, 3), and rotations from the bodies to the base, shape
            (n, n_bodies, 3, 3).
        """
        columns = np.asarray(self._placements(np.ascontiguousarray(arm.T)))
        columns = columns.T.reshape(len(arm), self._n_bodies, 4, 3)
        return columns[:, :, 0], columns[:, :, 1:].transpose(0, 1, 3, 2)
