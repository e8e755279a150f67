"""Inertia of bodies as simulators accept it: positive in all directions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

LEAST = 1e-9
"""Mass and inertia of bodies that have none, which simulators refuse or replace by 1 [kg, kg m2] (chosen)."""

THINNEST = 1e-6
"""Least second moment of a body over its largest [1] (chosen): those of plates and rods are rounded to less."""


def possible_tensor(robot: Robot, tensor: FloatArray) -> FloatArray:
    """Fill moments that a planar robot file omits: those about axes that no joint turns about.

    Args:
        robot: The robot.
        tensor: Inertia of one of its bodies [kg m2], shape (3, 3).

    Returns:
        Inertia that a body can have, with the same moment about the axes of the joints [kg m2], shape (3, 3).
    """
    axes = {joint.axis for joint in robot.joints if joint.rotary}
    full: FloatArray = tensor + 0.0
    if len(axes) <= 1:
        kept = float(tensor[next(iter(axes)), next(iter(axes))]) if axes else 0.0
        moments = np.linalg.eigvalsh(tensor)
        if moments[0] <= 0 or moments[2] > moments[0] + moments[1]:
            full = np.eye(3) * max(kept, LEAST)
    if not np.any(full):
        return np.eye(3) * LEAST
    second, turn = np.linalg.eigh(np.trace(full) / 2 * np.eye(3) - full)  # second moments of its mass
    least = THINNEST * second[-1]
    if second[0] >= 0 and np.linalg.eigvalsh(full)[0] > 0:
        return full
    second = np.maximum(second, least)
    return np.asarray(turn @ np.diag(second.sum() - second) @ turn.T)
