"""What a robot looks like: one bar for each body, from what its file says about lengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.specification import RobotSpecification

SLENDERNESS = 0.025
"""Radius of the bars as a share of the robot's extent, chosen."""

BAR = 0.3
"""Length of the bars of a robot without any length [m], chosen; they lie along x, one above the other."""

STOREY = 0.1
"""Height between such bars [m], chosen."""


@dataclass(frozen=True, eq=False)
class LinkShape:
    """Bar that stands for a body, in the frame of the body.

    Attributes:
        body: Number of the body (0-based).
        start: One end [m], shape (3,).
        end: The other end [m], shape (3,).
        radius: Radius [m].
    """

    body: int
    start: FloatArray
    end: FloatArray
    radius: float


def link_shapes(specification: RobotSpecification) -> tuple[LinkShape, ...]:
    """Give the bars of a robot.

    Args:
        specification: The robot file.

    Returns:
        One bar for each body that has a length, else up to its centre of mass; a body without either has none, unless
        that is so of all bodies.
    """
    ends = [_far_end(specification, body) for body in range(len(specification.bodies))]
    extent = sum(float(np.linalg.norm(end)) for end in ends)
    if extent == 0:
        storeys = [np.array([0.0, 0.0, STOREY * body]) for body in range(len(ends))]
        along = np.array([BAR, 0.0, 0.0])
        return tuple(LinkShape(body, at, at + along, SLENDERNESS * BAR) for body, at in enumerate(storeys))
    return tuple(
        LinkShape(body, np.zeros(3), end, SLENDERNESS * extent) for body, end in enumerate(ends) if np.any(end)
    )


def tool_offset(specification: RobotSpecification) -> FloatArray:
    """Return the tool point in the frame of the last body [m], shape (3,)."""
    given = specification.tool.position
    return np.array(specification.bodies[-1].length.value if given is None else given.value, dtype=float)


def _far_end(specification: RobotSpecification, body: int) -> FloatArray:
    last = body == len(specification.bodies) - 1
    length = tool_offset(specification) if last else np.array(specification.bodies[body].length.value, dtype=float)
    return length if np.any(length) else np.array(specification.bodies[body].center_of_mass.value, dtype=float)
