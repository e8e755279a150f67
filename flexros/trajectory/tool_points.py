"""Tool points of a specification, completed with the angles of the tool."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.line import Line
from flexros.trajectory.orientation import Extended, RollPitchYaw, quaternion, quaternion_of, rotation_vectors
from flexros.trajectory.path import AbstractPath, point
from flexros.trajectory.sequence import Sequence

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

Point: TypeAlias = tuple[float, ...]
Quaternion: TypeAlias = tuple[float, float, float, float]


def target_point(start: FloatArray, given: Point, n_position: int, *, relative: bool, name: str) -> FloatArray:
    """Complete a point; without angles it gets those of the start.

    Args:
        start: Tool coordinates at the start, shape (n_out,).
        given: All coordinates, or the positions alone.
        n_position: Number of leading coordinates that are positions.
        relative: Whether it is a displacement from the start.
        name: Name of the point in messages.

    Returns:
        Tool coordinates, shape (n_out,).

    Raises:
        InputError: Another number of coordinates, or a number that is not finite.
    """
    allowed = n_position if len(given) == n_position else start.size
    values = point(given, name, allowed)
    target: FloatArray = start.copy()
    target[:allowed] = start[:allowed] + values if relative else values
    return target


def with_angles(path: AbstractPath, start: FloatArray, n_position: int, end: Quaternion | None) -> AbstractPath:
    """Append the angles to the positions: constant, or rotated about one axis to the end orientation.

    Args:
        path: Path of the positions.
        start: Tool coordinates at the start, shape (n_out,).
        n_position: Number of leading coordinates that are positions.
        end: Orientation at the end; None to keep that of the start.

    Returns:
        Path of all coordinates.

    Raises:
        InputError: An end orientation for an output without roll, pitch and yaw, or no quaternion.
    """
    angles = start[n_position:]
    if end is not None:
        reference = _reference(start, n_position)
        vector = rotation_vectors(reference, [quaternion(end, "end_orientation")])[0]
        return RollPitchYaw(Extended(path, np.zeros(3), vector), reference)
    return Extended(path, angles, angles) if angles.size else path


def turning_lines(
    nodes: list[FloatArray], orientations: list[Quaternion], n_position: int, zone: float | tuple[float, ...]
) -> tuple[AbstractPath, ...]:
    """Return lines through points with orientations, as rotation vectors relative to that of the start.

    Between two points the rotation vector changes in proportion: a turn about one axis (slerp) from the start to
    the first point and wherever all turns have the same axis.

    Args:
        nodes: Tool coordinates of start and points, each of shape (6,); their own angles are not used, but the start's.
        orientations: Orientation at every point after the start.
        n_position: Number of leading coordinates that are positions, 3.
        zone: Radius of the corner zones [m]; 0 to stop at every point.

    Returns:
        One path with rounded corners, or one per segment.

    Raises:
        InputError: No orientation per point, no quaternion, or an output without roll, pitch and yaw.
    """
    reference = _reference(nodes[0], n_position)
    if len(orientations) != len(nodes) - 1:
        raise InputError(
            f"there are {len(orientations)} orientations for {len(nodes) - 1} points, allowed is one per point; "
            "correct the list orientations"
        )
    given = [quaternion(values, f"orientation {i}") for i, values in enumerate(orientations, start=1)]
    vectors = np.vstack((np.zeros(3), rotation_vectors(reference, given)))
    points = [np.concatenate((node[:3], vector)) for node, vector in zip(nodes, vectors, strict=True)]
    if np.any(np.asarray(zone) != 0.0):
        return (RollPitchYaw(Sequence(points, np.asarray(zone), n_position=3), reference),)
    return tuple(RollPitchYaw(Line(a, b, 3), reference) for a, b in pairwise(points))


def _reference(start: FloatArray, n_position: int) -> FloatArray:
    """Return the start orientation of six tool coordinates as a quaternion."""
    if start.size != 6 or n_position != 3:
        raise InputError(
            f"the path turns the tool but the output has {start.size} coordinates, allowed are six (x, y, z, roll, "
            "pitch, yaw); leave the orientation out or choose another output"
        )
    return quaternion_of(start[3:])
