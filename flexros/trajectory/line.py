"""Straight motion, of the tool or of the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath, point, text

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Line(AbstractPath):
    """Straight line of the tool, P(s) = start + s (end - start) / extent.

    The parameter is the length travelled by the position. The angles change in proportion; if they are a rotation
    vector relative to the start, that is a rotation about one axis (slerp, Shoemake 1985). The parameter of a pure
    rotation is its angle.

    Args:
        start: First point: positions [m], then angles [rad] if any, shape (n_out,).
        end: Last point, in the same form.
        n_position: Number of positions; default: all, at most 3.

    Raises:
        InputError: Start and end are the same, or are not points.
    """

    start_point: FloatArray
    end_point: FloatArray
    n_position: int

    def __init__(self, start: FloatArray, end: FloatArray, n_position: int | None = None) -> None:
        first = point(start, "start of the line")
        last = point(end, "end of the line", first.size)
        object.__setattr__(self, "start_point", first)
        object.__setattr__(self, "end_point", last)
        object.__setattr__(self, "n_position", min(3, first.size) if n_position is None else n_position)
        if self.extent == 0.0:
            raise InputError(
                f"the line starts and ends at {text(first)} so its length is 0 m, allowed is a length above 0; "
                "give another end or leave the line out"
            )

    @property
    def parameter_unit(self) -> str:  # type: ignore[override]
        """Unit of the parameter: "m", or "rad" for a turn on the spot."""
        n = self.n_position
        return "m" if np.any(self.start_point[:n] != self.end_point[:n]) else "rad"

    @property
    def extent(self) -> float:
        """Length [m], or angle [rad] of a turn on the spot."""
        return travelled(self.end_point - self.start_point, self.n_position)

    @property
    def n_out(self) -> int:
        """Number of coordinates."""
        return self.start_point.size

    @property
    def pace(self) -> float:
        """1: the parameter is the length."""
        return 1.0

    @property
    def coordinate_pace(self) -> FloatArray:
        """Size of the direction vector's components, shape (n_out,)."""
        return np.abs(self.end_point - self.start_point) / self.extent

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`."""
        return straight(self.start_point, self.end_point, s / self.extent, 1.0 / self.extent, order)


@dataclass(frozen=True, eq=False)
class JointMove(AbstractPath):
    """Straight motion in joint space: all joints follow one common parameter from 0 to 1.

    Args:
        start: First joint position [rad or m], shape (n_joints,).
        end: Last joint position [rad or m], shape (n_joints,).

    Raises:
        InputError: Start and end are the same, or are not joint positions.
    """

    start_point: FloatArray
    end_point: FloatArray
    parameter_unit = "1"

    def __init__(self, start: FloatArray, end: FloatArray) -> None:
        first = point(start, "start of the joint move")
        last = point(end, "end of the joint move", first.size)
        if np.array_equal(first, last):
            raise InputError(
                f"the joint move starts and ends at {text(first)} so no joint moves, allowed is a move of at least one "
                "joint; give another end or leave the move out"
            )
        object.__setattr__(self, "start_point", first)
        object.__setattr__(self, "end_point", last)

    @property
    def extent(self) -> float:
        """1."""
        return 1.0

    @property
    def n_out(self) -> int:
        """Number of joints."""
        return self.start_point.size

    @property
    def pace(self) -> float:
        """Euclidean norm of the whole move [rad or m]."""
        return float(np.linalg.norm(self.end_point - self.start_point))

    @property
    def coordinate_pace(self) -> FloatArray:
        """Size of the whole move of every joint [rad or m], shape (n_joints,)."""
        return np.abs(self.end_point - self.start_point)

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`."""
        return straight(self.start_point, self.end_point, s, 1.0, order)


def travelled(change: FloatArray, n_position: int) -> float:
    """Return the length [m] of a tool displacement, or its angle [rad] if it only turns.

    Args:
        change: Change of the tool coordinates, shape (n_out,).
        n_position: Number of leading coordinates that are positions.

    Returns:
        The length of the positions; where that is 0, the norm of the angles.
    """
    length = float(np.linalg.norm(change[:n_position]))
    return length if length > 0.0 else float(np.linalg.norm(change[n_position:]))


def straight(first: FloatArray, last: FloatArray, share: FloatArray, rate: float, order: int) -> FloatArray:
    """Return the points on a straight line and their derivatives.

    Args:
        first: Start, shape (n_out,).
        last: End, shape (n_out,); met exactly at share 1.
        share: Share of the way, shape (n,).
        rate: Derivative of the share with respect to the path parameter.
        order: Highest derivative.

    Returns:
        Shape (order + 1, n, n_out).
    """
    share = np.asarray(share, dtype=float)
    result = np.zeros((order + 1, share.size, first.size))
    result[0] = (1.0 - share)[:, None] * first + share[:, None] * last
    if order >= 1:
        result[1] = (last - first) * rate
    return result
