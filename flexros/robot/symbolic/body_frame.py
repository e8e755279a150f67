"""Frames of bodies: rotation and position of the centre of mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.robot.symbolic.kinematics import build_geometry, joint_origin, joint_rotation

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


@dataclass(frozen=True)
class BodyFrame:
    """Frame of a body.

    Attributes:
        rotation: From the body's frame to the base frame, SX (3, 3).
        center: Centre of mass in the base frame [m], SX (3, 1).
    """

    rotation: ca.SX
    center: ca.SX


def body_frame(robot: Robot, body: int, q: ca.SX, value: Callable[[str], Value]) -> BodyFrame:
    """Compute the frame of a body; one without free direction has that of the joint before it.

    Args:
        robot: The robot.
        body: Index of the body, one of `moved_bodies`.
        q: Arm coordinates [rad or m], SX (N, 1).
        value: Maps a parameter name to its number or symbol.
    """
    chain = robot.chain
    geometry = build_geometry(robot.spec, chain, value)
    # the modes of a link move what follows it, not the frame of the link
    joints = enumerate(chain.joints)
    last = max(index for index, joint in joints if joint.body < body or (joint.body == body and joint.mode is None))
    position, rotation = ca.SX.zeros(3), ca.SX.eye(3)
    q = geometry.placed(q)
    for index in range(last + 1):
        position = position + rotation @ joint_origin(chain, geometry, index, q[index])
        rotation = rotation @ joint_rotation(chain, index, q[index])
    first = chain.joints[last].body + (chain.joints[last].mode is not None)
    mass = geometry.frames[last].masses[body - first]
    return BodyFrame(rotation, position + rotation @ mass.center)


def moved_bodies(robot: Robot) -> tuple[int, ...]:
    """Return the indices of the bodies that some joint moves."""
    return tuple(range(robot.joints[0].body, len(robot.spec.bodies)))


def long_axis(robot: Robot, body: int) -> FloatArray:
    """Return the unit vector along the length of a body in its frame, the x axis for a body without length."""
    length = np.array(robot.spec.bodies[body].length.value, dtype=float)
    size = float(np.linalg.norm(length))
    return length / size if size > 0 else np.array([1.0, 0.0, 0.0])
