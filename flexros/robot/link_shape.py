"""Shape of a robot for display: one bar per body, from the lengths in its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.specification import RobotSpecification

SLENDERNESS = 0.025
"""Radius of the bars relative to the robot's extent (chosen)."""

BAR = 0.3
"""Length of the bars of a robot without lengths [m] (chosen); they are along x, one above the other."""

STOREY = 0.1
"""Distance between such bars [m] (chosen)."""


@dataclass(frozen=True, eq=False)
class LinkShape:
    """Bar that represents a body, in the frame of the body.

    Attributes:
        body: Index of the body.
        start: One end [m], shape (3,).
        end: The other end [m], shape (3,).
        radius: Radius [m].
    """

    body: int
    start: FloatArray
    end: FloatArray
    radius: float


def link_shapes(specification: RobotSpecification) -> tuple[LinkShape, ...]:
    """Return the bars of a robot.

    There is one bar per body along its length, else up to its centre of mass. A body with neither has none, unless
    that applies to all bodies.
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
