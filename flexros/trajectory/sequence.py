"""Straight segments with rounded corners, without stops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.line import travelled
from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath, point, text

if TYPE_CHECKING:
    from collections.abc import Sequence as ListOf

    from flexros.arrays import FloatArray

BLEND = np.polynomial.Polynomial([0.0, 1.0, 0.0, 0.0, 0.0, -7.0, 14.0, -10.0, 2.5])
"""Motion along the previous direction, as a fraction of the zone: h(u) from 0 to 1/2, h' from 1 to 0, h'' to h'''' zero
at both ends.

It is the integral of 1 - (35 u^4 - 84 u^5 + 70 u^6 - 20 u^7), the only polynomial of degree 9 or less that joins both
straight lines with four continuous derivatives (the form is chosen)."""


@dataclass(frozen=True, eq=False)
class Sequence(AbstractPath):
    """Straight segments through given points; every inner corner is rounded inside its zone.

    On the straight parts the parameter is the length (of the joint vector for joint moves). Within the zone radius r of
    a corner C, with unit directions a before and b after it and u = (distance to C along the parameter + r) / (2 r),

        P = C + r (2 h(u) - 1) a + r (1 - 2 h(1 - u)) b,      h = `BLEND`,

    so that four derivatives are continuous, the speed never exceeds that on the straight parts, and the path passes
    the corner at 0.1367 r |b - a|. The acceleration in a corner is not bounded by the limits of the time law, which
    act along the path: see `flexros.trajectory.limits.check_limits`.

    Args:
        points: At least two points, positions [m] followed by angles [rad] if any, or joint positions [rad or m],
            shape (n_points, n_out).
        zones: Zone radius at every inner point, in the unit of the parameter, shape (n_points - 2,); or one number.
        joints: The points are joint positions.
        n_position: Number of leading tool coordinates that are positions; default: all, at most 3.

    Raises:
        InputError: Two consecutive points are the same, a zone is not above 0, or reaches beyond half a segment.
    """

    points: FloatArray
    zones: FloatArray
    joints: bool
    parameter_unit: str
    knots: FloatArray
    directions: FloatArray

    def __init__(
        self,
        points: ListOf[FloatArray],
        zones: FloatArray | float,
        joints: bool = False,
        n_position: int | None = None,
    ) -> None:
        if len(points) < 2:
            raise InputError(f"the sequence has {len(points)} points, allowed are 2 or more; add points")
        size = point(points[0], "point 0 of the sequence").size
        nodes = np.array([point(p, f"point {i} of the sequence", size) for i, p in enumerate(points)])
        measured = size if joints else min(3, size) if n_position is None else n_position
        lengths = np.array([_segment_length(nodes, i, measured) for i in range(len(nodes) - 1)])
        radii = _zones(zones, len(nodes) - 2)
        for corner, radius in enumerate(radii, start=1):
            _check_zone(nodes, lengths, corner, float(radius))
        object.__setattr__(self, "points", nodes)
        object.__setattr__(self, "zones", radii)
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "parameter_unit", "rad" if joints else "m")
        object.__setattr__(self, "knots", np.concatenate(([0.0], np.cumsum(lengths))))
        object.__setattr__(self, "directions", np.diff(nodes, axis=0) / lengths[:, None])

    @property
    def extent(self) -> float:
        """Sum of the segments' lengths [m, or rad for joints]."""
        return float(self.knots[-1])

    @property
    def n_out(self) -> int:
        """Number of coordinates."""
        return int(self.points.shape[1])

    @property
    def pace(self) -> float:
        """1: the parameter is the length, in corners at most so."""
        return 1.0

    @property
    def coordinate_pace(self) -> FloatArray:
        """Largest component of the directions, shape (n_out,); that in corners is smaller."""
        result: FloatArray = np.max(np.abs(self.directions), axis=0)
        return result

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`."""
        s = np.asarray(s, dtype=float)
        result = np.zeros((order + 1, s.size, self.n_out))
        segment = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.directions) - 1)
        share = (s - self.knots[segment]) / (self.knots[segment + 1] - self.knots[segment])
        result[0] = (1.0 - share)[:, None] * self.points[segment] + share[:, None] * self.points[segment + 1]
        if order >= 1:
            result[1] = self.directions[segment]
        for corner, radius in enumerate(self.zones, start=1):
            inside = np.abs(s - self.knots[corner]) < radius
            if np.any(inside):
                result[:, inside] = self._corner(corner, s[inside], order)
        return result

    def _corner(self, corner: int, s: FloatArray, order: int) -> FloatArray:
        """Return the derivatives inside a zone, shape (order + 1, n, n_out)."""
        radius = float(self.zones[corner - 1])
        before, after = self.directions[corner - 1], self.directions[corner]
        u = (s - self.knots[corner] + radius) / (2.0 * radius)
        result = np.empty((order + 1, s.size, self.n_out))
        for k in range(order + 1):
            blend = BLEND.deriv(k) if k else BLEND
            scale = 2.0 * radius / (2.0 * radius) ** k
            old = blend(u) * scale - (radius if k == 0 else 0.0)
            new = (-1.0) ** (k + 1) * blend(1.0 - u) * scale + (radius if k == 0 else 0.0)
            result[k] = old[:, None] * before + new[:, None] * after
        result[0] += self.points[corner]
        return result


def _segment_length(nodes: FloatArray, i: int, measured: int) -> float:
    change = nodes[i + 1] - nodes[i]
    length = float(np.linalg.norm(change[:measured]))
    if length > 0.0:
        return length
    if travelled(change, measured) > 0.0:
        raise InputError(
            f"points {i} and {i + 1} of the sequence are both at {text(nodes[i][:measured])} and only the "
            "orientation differs, allowed are segments with a length; turn on the spot in a line of its own or set "
            "zone to 0"
        )
    raise InputError(
        f"points {i} and {i + 1} of the sequence are both {text(nodes[i])} so the segment has no length, "
        "allowed are different points; leave one out"
    )


def _zones(zones: FloatArray | float, corners: int) -> FloatArray:
    given = np.asarray(zones, dtype=float)
    if given.ndim > 1 or (given.ndim == 1 and given.size != corners):
        raise InputError(
            f"the sequence has {corners} corners but {given.size} zones, allowed is one zone per corner or one number; "
            "correct the zones"
        )
    result: FloatArray = np.broadcast_to(given, (corners,)).copy()
    return result


def _check_zone(nodes: FloatArray, lengths: FloatArray, corner: int, radius: float) -> None:
    name = f"corner {corner} at {text(nodes[corner])}"
    if not (np.isfinite(radius) and radius > 0.0):
        raise InputError(
            f"the zone of {name} is {radius:g}, allowed is a finite radius above 0; correct the zone or make the "
            "moves stop at the corner"
        )
    shorter = float(min(lengths[corner - 1], lengths[corner]))
    if radius > 0.5 * shorter * (1.0 + 1e-12):
        raise InputError(
            f"the zone of {name} is {radius:g}, allowed is at most half the shorter neighbouring segment, "
            f"{0.5 * shorter:.6g}, so that zones do not overlap; make the zone smaller or move the points apart"
        )
