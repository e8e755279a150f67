"""Cornering deviations after ISO 9283:1998, 8.5: rounding CR and overshoot CO at the corners of a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.path_geometry import CommandedPath, path_through

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.cycles import Cycle
    from flexros.arrays import FloatArray

_SHARPEST_BEND = np.radians(20.0)
"""A path that turns by more than this within two samples has a corner there."""
_SMOOTH_BEND = np.radians(2.0)
"""A corner between two samples bends the path by more than this at both."""
_STRAIGHT = np.cos(np.radians(0.1))
"""A leg is straight where its direction stays within a tenth of a degree."""
_LEG_SAMPLES, _LEG_LENGTH = 5, 1e-3
"""Both legs of a corner are straight over so many samples and so far [m] (chosen); transitions of curves are none."""
_REVERSAL = np.cos(np.radians(170.0))
"""A path that turns by more than 170 degrees reverses; the standard has no corner there."""


@dataclass(frozen=True, eq=False)
class Corner:
    """A corner of the commanded path.

    Attributes:
        point: Intersection of the two legs [m], shape (3,).
        position: Distance along the path [m].
        before: Unit direction of the leg before it, shape (3,).
        after: Unit direction of the leg after it, shape (3,).
        before_length: Straight length of the leg before it [m].
        after_length: Straight length of the leg after it [m].
    """

    point: FloatArray
    position: float
    before: FloatArray
    after: FloatArray
    before_length: float = np.inf
    after_length: float = np.inf

    @property
    def angle(self) -> float:
        """Angle by which the path turns [rad]."""
        return float(np.arccos(np.clip(self.before @ self.after, -1.0, 1.0)))


@dataclass(frozen=True, eq=False)
class CornerDeviation:
    """Deviations at one corner over all cycles.

    Attributes:
        corner: The corner.
        rounding: CR, the largest over the cycles of the smallest distance from the corner to the attained path [m].
        overshoot: CO, the largest distance from the second leg on its outer side [m]; 0 where there is none.
    """

    corner: Corner
    rounding: float
    overshoot: float

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers with their units in the keys."""
        return {
            "point_m": self.corner.point.tolist(),
            "angle_rad": self.corner.angle,
            "CR_m": self.rounding,
            "CO_m": self.overshoot,
        }


def find_corners(points: FloatArray) -> tuple[Corner, ...]:
    """Find the sharp corners between straight legs of a sampled path; the corner itself need not be a sample.

    A rounded zone is not a corner of the commanded path and is not found.

    Args:
        points: Commanded positions [m], shape (n, 3).

    Returns:
        The corners in order of travel.
    """
    path = path_through(points)
    if len(path.vertices) < 6:
        return ()
    step = np.diff(path.vertices, axis=0)
    direction = step / np.linalg.norm(step, axis=1, keepdims=True)
    bend = np.arccos(np.clip(np.sum(direction[1:] * direction[:-1], axis=1), -1.0, 1.0))
    corners: list[Corner] = []
    k = 1
    while k < len(bend):
        if bend[k] <= _SMOOTH_BEND:
            k += 1
            continue
        # The corner is vertex k + 1, or between it and the next one if the path turns at both.
        last = k + 2 if k + 1 < len(bend) and bend[k + 1] > _SMOOTH_BEND else k + 1
        sharp = float(np.sum(bend[k:last])) > _SHARPEST_BEND and float(direction[k] @ direction[last]) > _REVERSAL
        if sharp:
            corner = _corner(path, direction, k, last)
            corners += [corner] if corner is not None else []
        k = last
    return tuple(corners)


def _corner(path: CommandedPath, direction: FloatArray, first: int, last: int) -> Corner | None:
    """Intersect the leg that ends with segment `first` with the one that starts with segment `last`."""
    before, after = direction[first], direction[last]
    back = _straight_segments(direction[first::-1] @ before)
    ahead = _straight_segments(direction[last:] @ after)
    if min(back, ahead) < _LEG_SAMPLES:
        return None
    vertices, arc_length = path.vertices, path.arc_length
    gap = vertices[last] - vertices[first + 1]
    lengths, *_ = np.linalg.lstsq(np.column_stack([before, after]), gap, rcond=None)
    position = float(arc_length[first + 1] + lengths[0])
    behind, beyond = position - float(arc_length[first + 1 - back]), float(arc_length[last + ahead]) - position
    if min(behind, beyond) < _LEG_LENGTH:
        return None
    return Corner(vertices[first + 1] + lengths[0] * before, position, before, after, behind, beyond)


def _straight_segments(cosine: FloatArray) -> int:
    """Count the segments, starting with the first, whose direction is that of the leg."""
    bent = np.flatnonzero(cosine < _STRAIGHT)
    return int(bent[0]) if len(bent) else len(cosine)


def corner_deviations(cycles: Sequence[Cycle], corners: Sequence[Corner] | None = None) -> tuple[CornerDeviation, ...]:
    """Evaluate rounding and overshoot at each corner, the worst of all cycles.

    CR = max_j min_k |Z_jk - c|;  CO = largest distance of Z from the line of the second leg, counted on the side the
    first leg points to (ISO 9283:1998, 8.5). Only the time is used in which the command is on the straight parts of the
    two legs, and closer to this corner than to its neighbours.

    Args:
        cycles: Passes of the same commanded path, at least one.
        corners: Programmed corners; None to find those of the commanded path.

    Returns:
        One result per corner, in order of travel.
    """
    used = find_corners(cycles[0].commanded) if corners is None else tuple(corners)
    if not used:
        return ()
    positions = np.array([corner.position for corner in used])
    edges = np.concatenate([[-np.inf], 0.5 * (positions[1:] + positions[:-1]), [np.inf]])
    results = []
    for corner, low, high in zip(used, edges[:-1], edges[1:], strict=True):
        rounding, overshoot = 0.0, 0.0
        for cycle in cycles:
            travelled = cycle.arc_length()
            first = max(low, corner.position - corner.before_length)
            last = min(high, corner.position + corner.after_length)
            offset = cycle.attained[(travelled >= first) & (travelled <= last)] - corner.point
            rounding = max(rounding, _distance_to_polyline(offset))
            overshoot = max(overshoot, _overshoot(offset, corner))
        results.append(CornerDeviation(corner, rounding, overshoot))
    return tuple(results)


def _distance_to_polyline(offset: FloatArray) -> float:
    """Return the distance from the origin to the polyline through the given points [m]."""
    path = path_through(offset)
    return float(path.project(np.zeros((1, 3))).distance[0])


def _overshoot(offset: FloatArray, corner: Corner) -> float:
    outward = corner.before - (corner.before @ corner.after) * corner.after
    outside = offset @ outward > 0.0
    across = offset - np.outer(offset @ corner.after, corner.after)
    return float(np.max(np.linalg.norm(across[outside], axis=1), initial=0.0))
