"""Geometry of a sampled commanded path: distance to its polyline, to 30 nm, and the underlying circle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import FloatArray, IntArray

_SAME_POINT = 1e-7
"""Samples closer than this [m] to the previous one are the same vertex (the path is at rest there)."""
_STRAIGHT = 1e-8
"""Largest distance of the path that is searched from the commanded one, by vertices left out [m] (chosen)."""
_LONGEST = 1e-3
"""Length of a segment over the extent of the path up to which vertices are left out [1] (chosen)."""
_WORTH = 0.002
"""Share of vertices that must go for another pass over those that are left [1] (chosen)."""
_PIECE = 2.0
"""Length of the pieces into which a path is cut to search it, over the median of its segments [1] (chosen)."""
_SAME_PASS = 1e-8
"""Distance between vertices of two passes [m] up to which the second repeats the first (chosen)."""
_MOST_DISTANCES = 500_000
"""Distances that are computed at once (chosen): some 50 MB."""
_ROWS_AT_ONCE = 100_000
"""Rows that are computed at once (chosen): temporary arrays of a log of half an hour would be as large as the log."""
_CIRCLE_SAMPLE = 1000
"""Vertices that a circle must pass before all of them are fitted (chosen)."""
_FIRST_CANDIDATES = 8
"""Number of candidate segments of each point at first; more are taken until the nearest one is proved."""
_GROUP = 2.0
"""Longest over shortest segment of a group that is searched by itself [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Nearest points of the commanded path.

    Attributes:
        distance: Distance to the path [m], shape (n,).
        nearest: Nearest point of the path [m], shape (n, 3).
        position: Distance along the path from its beginning to the nearest point [m], shape (n,).
    """

    distance: FloatArray
    nearest: FloatArray
    position: FloatArray


@dataclass(frozen=True, eq=False)
class CommandedPath:
    """Polyline through the samples of a commanded path.

    Attributes:
        vertices: Corners of the polyline [m], shape (n, 3), n >= 1, consecutive ones distinct.
        arc_length: Distance along the polyline to each vertex [m], shape (n,).
    """

    vertices: FloatArray
    arc_length: FloatArray

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        return float(self.arc_length[-1])

    @property
    def extent(self) -> float:
        """Diagonal of the box around the path [m]."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    def project(self, points: FloatArray) -> Projection:
        """Find the nearest point of the path, on the segments and not only at the vertices, for each given point.

        Args:
            points: Attained positions [m], shape (n, 3).

        Returns:
            Distance, nearest point and position along the path. No other point of the path is nearer by more than
            30 nm: 10 nm for vertices on straight lines and 17 nm for repeated passes, which are not searched.
        """
        if len(self.vertices) == 1:
            distance = np.linalg.norm(points - self.vertices[0], axis=1)
            nearest = np.repeat(self.vertices, len(points), axis=0)
            return Projection(distance, nearest, np.zeros(len(points)))
        return _project(self, points)

    def chord_error(self) -> float:
        """Return the largest deviation of the path from its chords [m]: max of chord times turning angle over eight."""
        if len(self.vertices) < 3:
            return 0.0
        # Blocks share two vertices, so that each turn lies in one of them.
        starts = range(0, len(self.vertices) - 2, _ROWS_AT_ONCE)
        return max(_largest_sag(self.vertices[start : start + _ROWS_AT_ONCE + 2]) for start in starts)


def path_through(points: FloatArray) -> CommandedPath:
    """Build the polyline through samples of a commanded path, without the samples at rest.

    Args:
        points: Commanded positions in order of time [m], shape (n, 3), n >= 1.
    """
    step = step_lengths(points)
    if np.all(step >= _SAME_POINT):
        vertices, lengths = points, step
    else:
        kept, last = np.zeros(len(points), dtype=bool), 0
        kept[0] = True
        for index in range(1, len(points)):
            if np.linalg.norm(points[index] - points[last]) >= _SAME_POINT:
                kept[index], last = True, index
        vertices = points[kept]
        lengths = step_lengths(vertices)
    return CommandedPath(vertices, np.concatenate([[0.0], np.cumsum(lengths)]))


def distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the distance between the points of each row, |a - b|, in blocks of rows.

    Args:
        first: Points a [m], shape (n, 3).
        second: Points b [m], shape (n, 3).

    Returns:
        Distances [m], shape (n,).
    """
    result = np.empty(len(first))
    for start in range(0, len(first), _ROWS_AT_ONCE):
        rows = slice(start, start + _ROWS_AT_ONCE)
        result[rows] = np.linalg.norm(first[rows] - second[rows], axis=1)
    return result


def step_lengths(points: FloatArray) -> FloatArray:
    """Return the distance from each point to the next [m], of points of shape (n, 3), shape (n - 1,)."""
    return distances(points[1:], points[:-1])


def _largest_sag(vertices: FloatArray) -> float:
    step = np.diff(vertices, axis=0)
    length = np.linalg.norm(step, axis=1)
    direction = step / length[:, None]
    turning = np.arccos(np.clip(np.sum(direction[1:] * direction[:-1], axis=1), -1.0, 1.0))
    smooth = turning < np.radians(20.0)
    sag = np.minimum(length[1:], length[:-1]) * turning / 8.0
    return float(np.max(sag[smooth], initial=0.0))


def _searched(path: CommandedPath) -> tuple[FloatArray, FloatArray]:
    """Return vertices with their distances along the path that have all of it, and segments of similar length.

    A path that repeats itself is searched once, and vertices on straight lines are left out: slow motions would have
    thousands of segments where fast ones have one. Long segments are cut, because the longest one decides how many
    others may be nearer than the best of those that were looked at.
    """
    kept = _needed(path.vertices[: _first_passes(path.vertices)])
    vertices, arc_length = path.vertices[kept], path.arc_length[kept]
    steps = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    pieces = np.ceil(steps / (_PIECE * np.median(steps))).astype(np.int64)
    segment = np.repeat(np.arange(len(steps)), pieces)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[segment]
    cut = vertices[segment] + share[:, None] * np.diff(vertices, axis=0)[segment]
    at = arc_length[segment] + share * np.diff(arc_length)[segment]
    return np.vstack([cut, vertices[-1:]]), np.append(at, arc_length[-1])


def _first_passes(vertices: FloatArray) -> int:
    """Return the number of vertices after which a path only repeats segments that were before."""
    new = np.ones(len(vertices) - 1, dtype=bool)
    factors = np.random.default_rng(0).integers(1, 2**62, size=(2, 3)) | 1
    for offset in (0.0, 0.5):  # two grids, since equal numbers may round differently in one
        keys = np.empty(len(new), dtype=np.int64)
        for start in range(0, len(new), _ROWS_AT_ONCE):
            cells = np.floor(vertices[start : start + _ROWS_AT_ONCE + 1] / _SAME_PASS + offset).astype(np.int64)
            keys[start : start + _ROWS_AT_ONCE] = (cells[:-1] * factors[0]).sum(axis=1) ^ (cells[1:] * factors[1]).sum(
                axis=1
            )
        first = np.zeros(len(keys), dtype=bool)
        first[np.unique(keys, return_index=True)[1]] = True
        new &= first
    return int(np.flatnonzero(new)[-1]) + 2


def _needed(vertices: FloatArray) -> IntArray:
    """Return vertices whose polyline is within `_STRAIGHT` of that of all, by leaving out every other one at a time.

    The distance of a segment from what it stands for is at most that of the two it replaces plus that of their corner.
    """
    kept, distance = np.arange(len(vertices)), np.zeros(len(vertices) - 1)
    longest = float(np.linalg.norm(np.diff(vertices, axis=0), axis=1).max())
    longest = max(longest, _LONGEST * float(np.linalg.norm(np.ptp(vertices, axis=0))))
    while len(kept) > 2:
        start, middle, end = (vertices[kept[k::2]] for k in range(3))
        n = len(end)
        chord, offset = end - start[:n], middle[:n] - start[:n]
        square = np.sum(chord**2, axis=1)
        along = np.clip(np.sum(offset * chord, axis=1) / np.where(square > 0, square, np.inf), 0.0, 1.0)
        off = np.linalg.norm(offset - along[:, None] * chord, axis=1)
        off += np.maximum(distance[0::2][:n], distance[1::2][:n])
        needless = np.flatnonzero((off < _STRAIGHT) & (square <= longest**2))
        if len(needless) <= _WORTH * len(kept):
            break
        distance[2 * needless] = off[needless]
        kept, distance = np.delete(kept, 1 + 2 * needless), np.delete(distance, 1 + 2 * needless)
    return kept


def _project(path: CommandedPath, points: FloatArray) -> Projection:
    vertices, arc_length = _searched(path)
    nearest_segment = _NearestSegment(vertices, points)
    waiting = nearest_segment.look_at(None, np.arange(len(points)), _FIRST_CANDIDATES)
    # The longest of all segments proves little where the others are short: each group has a bound of its own.
    for group in nearest_segment.groups() if len(waiting) else ():
        nearest_segment.look_at(group, waiting)
    n = len(points)
    nearest, position = np.empty((n, 3)), np.empty(n)
    for start in range(0, n, _ROWS_AT_ONCE):
        rows = slice(start, start + _ROWS_AT_ONCE)
        at, share = nearest_segment.segment[rows], nearest_segment.fraction[rows]
        nearest[rows] = vertices[at] + share[:, None] * (vertices[at + 1] - vertices[at])
        position[rows] = arc_length[at] + share * (arc_length[at + 1] - arc_length[at])
    return Projection(nearest_segment.distance, nearest, position)


class _NearestSegment:
    """The nearest segment of each point among those that were looked at.

    Attributes:
        distance: Distance to it [m], shape (n,).
        segment: Its number, shape (n,).
        fraction: Where on it the nearest point is, 0 at its start to 1 at its end, shape (n,).
    """

    def __init__(self, vertices: FloatArray, points: FloatArray) -> None:
        self._vertices, self._points = vertices, points
        self._lengths = step_lengths(vertices)
        n = len(points)
        self.distance = np.full(n, np.inf)
        self.segment = np.zeros(n, dtype=np.int64)
        self.fraction = np.zeros(n)

    def groups(self) -> Iterator[IntArray]:
        """Yield the segments in groups of similar length, the longest first."""
        group = np.floor(np.log(self._lengths.max() / self._lengths) / np.log(_GROUP)).astype(np.int64)
        for number in np.unique(group):
            yield np.flatnonzero(group == number)

    def look_at(self, segments: IntArray | None, rows: IntArray, most: int | None = None) -> IntArray:
        """Look at more and more of some segments, those with the nearest centres first, until no other is nearer.

        Args:
            segments: Numbers of the segments; None for all of them.
            rows: Numbers of the points.
            most: Number of segments after which the search ends; None searches to the end.

        Returns:
            Numbers of the points for which a segment that was not looked at may be nearer.
        """
        half = 0.5 * float(np.max(self._lengths if segments is None else self._lengths[segments]))
        starts = self._vertices[:-1] if segments is None else self._vertices[segments]
        centres = (self._vertices[1:] if segments is None else self._vertices[segments + 1]) - starts
        centres *= 0.5
        centres += starts
        tree, n = cKDTree(centres), len(centres)
        waiting, k = rows, min(_FIRST_CANDIDATES, n)
        while True:
            unproved = []
            for part in _parts(waiting, k):
                far, candidates = (values.reshape(-1, k) for values in tree.query(self._points[part], k=k))
                self._take(candidates if segments is None else segments[candidates], part)
                # The centre of any other segment is beyond the farthest candidate: it is at least far - half away.
                unproved.append(part[(far[:, -1] - half < self.distance[part]) & (k < n)])
            waiting = np.concatenate(unproved)
            if not len(waiting) or (most is not None and k >= most):
                return waiting
            k = min(4 * k, n)

    def _take(self, candidates: IntArray, rows: IntArray) -> None:
        """Keep the nearest of some candidates, shape (len(rows), k), where it is nearer than the one known."""
        starts = self._vertices[candidates]
        offset = self._points[rows][:, None, :] - starts
        step = self._vertices[candidates + 1] - starts
        along = np.clip(np.sum(offset * step, axis=2) / np.sum(step**2, axis=2), 0.0, 1.0)
        gap = np.linalg.norm(offset - along[..., None] * step, axis=2)
        row, best = np.arange(len(rows)), np.argmin(gap, axis=1)
        nearer = gap[row, best] < self.distance[rows]
        row, best, rows = row[nearer], best[nearer], rows[nearer]
        self.distance[rows], self.segment[rows] = gap[row, best], candidates[row, best]
        self.fraction[rows] = along[row, best]


def _parts(rows: IntArray, k: int) -> list[IntArray]:
    """Split rows so that their distances to k candidates fit into memory."""
    return np.array_split(rows, 1 + len(rows) * k // _MOST_DISTANCES)


@dataclass(frozen=True, eq=False)
class Circle:
    """A full circle in space.

    Attributes:
        centre: Centre [m], shape (3,).
        radius: Radius [m].
        normal: Unit vector normal to its plane, in the sense of travel, shape (3,).
        start: Unit vector from the centre to the first point of the path, shape (3,).
    """

    centre: FloatArray
    radius: float
    normal: FloatArray
    start: FloatArray

    def project(self, points: FloatArray) -> Projection:
        """Find the nearest point of the circle; in its plane the distance is the radial deviation | |Z - c| - r |.

        Args:
            points: Attained positions [m], shape (n, 3), none on the axis of the circle.

        Returns:
            Distance, nearest point, and position along the circle from its first point, 0 to 2 pi r.
        """
        # In one array: offset from the centre, its part in the plane, the direction, the nearest point.
        nearest = points - self.centre
        nearest -= np.outer(nearest @ self.normal, self.normal)
        nearest /= np.linalg.norm(nearest, axis=1, keepdims=True)
        angle = np.arctan2(nearest @ np.cross(self.normal, self.start), nearest @ self.start)
        nearest *= self.radius
        nearest += self.centre
        return Projection(distances(points, nearest), nearest, self.radius * np.mod(angle, 2.0 * np.pi))


def circle_behind(path: CommandedPath, tolerance: float = 1e-6) -> Circle | None:
    """Find the full circle on which all vertices of a path lie, if there is one.

    Least squares in the plane of the path: |p|^2 = 2 c.p + (r^2 - |c|^2) (Kasa 1976).

    Args:
        path: The commanded path.
        tolerance: Largest distance of a vertex from the circle [m].

    Returns:
        The circle, or None where the path is not a circle or covers less than a full turn.
    """
    if len(path.vertices) < 8 or not _may_be_circle(path, tolerance):
        return None
    middle = path.vertices.mean(axis=0)
    _, _, frame = np.linalg.svd(path.vertices - middle, full_matrices=False)
    flat = (path.vertices - middle) @ frame[:2].T
    system = np.column_stack([2.0 * flat, np.ones(len(flat))])
    solution, *_ = np.linalg.lstsq(system, np.sum(flat**2, axis=1), rcond=None)
    radius = float(np.sqrt(max(solution[2] + solution[0] ** 2 + solution[1] ** 2, 0.0)))
    if radius <= tolerance or radius > path.extent:
        return None
    centre = middle + solution[:2] @ frame[:2]
    start = path.vertices[0] - centre
    travel = np.unwrap(np.arctan2(flat[:, 1] - solution[1], flat[:, 0] - solution[0]))
    normal = np.sign(travel[-1] - travel[0]) * np.cross(frame[0], frame[1])
    circle = Circle(centre, radius, normal, start / np.linalg.norm(start))
    once_round = abs(travel[-1] - travel[0]) > np.radians(350.0)
    if not once_round or float(np.max(circle.project(path.vertices).distance)) > tolerance:
        return None
    return circle


def _may_be_circle(path: CommandedPath, tolerance: float) -> bool:
    """Whether some of the vertices lie near one plane and one sphere, as those of every circle do.

    The best plane and the best sphere through them leave no more, in the mean square, than those of the circle: the
    tolerance t, and | |p - c|^2 - r^2 | <= (2 r + t) t with r <= extent. Ten times that is let through for rounding.
    """
    rows = np.linspace(0, len(path.vertices) - 1, min(len(path.vertices), _CIRCLE_SAMPLE)).astype(np.int64)
    points = path.vertices[rows] - path.vertices[rows].mean(axis=0)
    if np.linalg.svd(points, compute_uv=False)[-1] > 10.0 * tolerance * np.sqrt(len(points)):
        return False
    system, square = np.column_stack([2.0 * points, np.ones(len(points))]), np.sum(points**2, axis=1)
    left = square - system @ np.linalg.lstsq(system, square, rcond=None)[0]
    return bool(np.sqrt(np.mean(left**2)) <= 10.0 * (2.0 * path.extent + tolerance) * tolerance)
