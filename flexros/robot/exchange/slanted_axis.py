"""The turn of a body whose joint axis is not along x, y or z of the frame before it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

ALIGNED = 1e-6
"""Largest 1 - cosine between a joint axis and a coordinate axis that counts as parallel [1] (chosen): 1.4 mrad."""


def turn_to(axis: FloatArray) -> tuple[int, FloatArray]:
    """Return the coordinate axis next to an axis, and the smallest rotation that brings it there or opposite to it.

    Args:
        axis: Unit vector, shape (3,).

    Returns:
        Index of the coordinate axis, 0 to 2, and the rotation matrix, shape (3, 3); the identity for a parallel axis.
    """
    index = int(np.argmax(np.abs(axis)))
    if abs(axis[index]) > 1 - ALIGNED:
        return index, np.eye(3)
    own = np.eye(3)[index]
    aimed = axis * np.sign(axis[index])
    cross = np.cross(own, aimed)
    matrix = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    return index, np.eye(3) + matrix + matrix @ matrix / (1 + own @ aimed)  # Rodrigues' formula


def roll_pitch_yaw(rotation: FloatArray) -> FloatArray:
    """Return the angles about fixed axes of a rotation R_z(yaw) R_y(pitch) R_x(roll), as in a URDF.

    Args:
        rotation: Rotation matrix, shape (3, 3), with a pitch below a right angle.

    Returns:
        Roll, pitch, yaw [rad], shape (3,).
    """
    R = rotation
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])
