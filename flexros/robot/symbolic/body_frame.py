"""Where a body is: rotation of its frame and position of its centre of mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.robot.symbolic.kinematics import build_geometry, joint_origin, joint_rotation

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.robot.specification import RobotSpecification
    from flexros.robot.symbolic.chain import Chain
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


def body_frame(
    specification: RobotSpecification, chain: Chain, body: int, q: ca.SX, value: Callable[[str], Value]
) -> BodyFrame:
    """Find the frame of a body.

    Args:
        specification: The robot file.
        chain: Its joints.
        body: Number of the body (0-based), one of `moved_bodies`.
        q: Arm coordinates, SX (N, 1).
        value: Gives number or symbol of a named parameter.

    Returns:
        The frame; a body without free direction has that of the joint before it.
    """
    geometry = build_geometry(specification, chain, value)
    last = max(index for index, joint in enumerate(chain.joints) if joint.body <= body)
    position, rotation = ca.SX.zeros(3), ca.SX.eye(3)
    for index in range(last + 1):
        position = position + rotation @ joint_origin(chain, geometry, index, q[index])
        rotation = rotation @ joint_rotation(chain, index, q[index])
    mass = geometry.frames[last].masses[body - chain.joints[last].body]
    return BodyFrame(rotation, position + rotation @ mass.center)


def moved_bodies(chain: Chain, n_bodies: int) -> tuple[int, ...]:
    """List the bodies (0-based) that some joint moves.

    Args:
        chain: The chain.
        n_bodies: Number of bodies of the robot.
    """
    return tuple(range(chain.joints[0].body, n_bodies))


def long_axis(specification: RobotSpecification, body: int) -> FloatArray:
    """Return the unit vector along the length of a body, in its frame, or along its x axis where it has no length.

    Args:
        specification: The robot file.
        body: Number of the body (0-based).

    Returns:
        Direction [1], shape (3,).
    """
    length = np.array(specification.bodies[body].length.value, dtype=float)
    size = float(np.linalg.norm(length))
    return length / size if size > 0 else np.array([1.0, 0.0, 0.0])
