"""Error of the tool in one run: distance to the commanded path, and difference at the same time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from flexros.analysis.cycles import Cycle
from flexros.analysis.elapsed_time import elapsed_seconds
from flexros.analysis.error_statistics import ErrorStatistics, error_statistics
from flexros.analysis.path_geometry import circle_behind, distances, path_through
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.analysis.path_geometry import Circle, CommandedPath
    from flexros.arrays import FloatArray
    from flexros.logs.time_series import PoseSeries

AXES = ("x", "y", "z")

AT_ONCE = 100_000
"""Orientations that are interpolated at once (chosen): rotations take several times the memory of their numbers."""


@dataclass(frozen=True, eq=False)
class PathError:
    """Tool error of one run; all series are at the stamps of tool_pose that lie within tool_reference.

    Attributes:
        shape: Description of the commanded path, e.g. "circle of radius 25 mm".
        run: Commanded and attained pose over time, times from the start of the log [s]; components not in `axes` are 0.
        axes: The position components used, e.g. ("x", "z").
        length: Length of the commanded path [m].
        nearest: Point of the commanded path nearest to the attained one [m], shape (n, 3).
        position: Distance of that point along the path [m], shape (n,).
        distance: Distance to the path [m], shape (n,): radial deviation | |Z - c| - r | where the path is a circle.
        time_difference: Distance to the commanded position of the same time, |Z(t) - Zd(t)| [m], shape (n,).
        angle: Angle to the commanded orientation of the same time [rad], shape (n,); None where none is commanded.
        path: Figures of `distance` [m].
        synchronised: Figures of `time_difference` [m].
        orientation: Figures of `angle` [rad]; None where no orientation is commanded.
        chord_error: Largest deviation of the path from the chords between its samples [m]; 0 for a circle.
    """

    shape: str
    run: Cycle
    axes: tuple[str, ...]
    length: float
    nearest: FloatArray
    position: FloatArray
    distance: FloatArray
    time_difference: FloatArray
    angle: FloatArray | None
    path: ErrorStatistics
    synchronised: ErrorStatistics
    orientation: ErrorStatistics | None
    chord_error: float

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers; metres and radians."""
        return {
            "shape": self.shape,
            "axes": list(self.axes),
            "length_m": self.length,
            "path_error_m": self.path.as_dict(),
            "time_synchronised_error_m": self.synchronised.as_dict(),
            "orientation_error_rad": None if self.orientation is None else self.orientation.as_dict(),
            "chord_error_m": self.chord_error,
        }


def path_error(
    pose: PoseSeries,
    reference: PoseSeries,
    *,
    start: int | None = None,
    axes: tuple[str, ...] | None = None,
    turned: bool = True,
) -> PathError:
    """Compare the attained tool pose with the commanded one.

    The commanded path is the polyline through the reference samples; where all of them lie on a full circle, the circle
    itself. A reference of another rate is interpolated linearly in time for the time-synchronised error.

    Args:
        pose: Attained poses, in order of stamps.
        reference: Commanded poses, in order of stamps.
        start: Stamp of time 0 [ns]; None for the first stamp of `pose`.
        axes: Position components to use; None for those that move in the pose or the reference.
        turned: Whether to use the orientation, if the reference commands one.

    Returns:
        Error series and figures.

    Raises:
        InputError: The two series share no time or contain values that are not finite, or `axes` is not of x, y, z.
    """
    run = _common_run(pose, reference, int(pose.stamp[0]) if start is None else start, turned)
    used = _moving_axes(run) if axes is None else axes
    if not used or not set(used) <= set(AXES):
        raise InputError(f"axes {', '.join(used) or 'none'} were given for the path error: use one or more of x, y, z")
    run = replace(run, commanded=_only(run.commanded, used), attained=_only(run.attained, used))
    path = path_through(_only(reference.position, used))
    circle = circle_behind(path)
    projection = path.project(run.attained) if circle is None else circle.project(run.attained)
    difference = distances(run.attained, run.commanded)
    angle = _angle(run)
    return PathError(
        shape=_shape(path, circle),
        run=run,
        axes=tuple(used),
        length=path.length,
        nearest=projection.nearest,
        position=projection.position,
        distance=projection.distance,
        time_difference=difference,
        angle=angle,
        path=error_statistics(projection.distance, run.time, projection.position),
        synchronised=error_statistics(difference, run.time, projection.position),
        orientation=None if angle is None else error_statistics(angle, run.time, projection.position),
        chord_error=path.chord_error() if circle is None else 0.0,
    )


def _only(position: FloatArray, axes: tuple[str, ...]) -> FloatArray:
    """Set the other components to 0; the same array where they are, since that of a long log is large."""
    others = [index for index, axis in enumerate(AXES) if axis not in axes]
    if not any(np.any(position[:, index]) for index in others):
        return position
    return position * np.array([axis in axes for axis in AXES], dtype=np.float64)


def _shape(path: CommandedPath, circle: Circle | None) -> str:
    if circle is not None:
        return f"circle of radius {1e3 * circle.radius:.6g} mm"
    return f"path of {path.length:.4g} m" if path.length > 0.0 else "position"


def _common_run(pose: PoseSeries, reference: PoseSeries, start: int, turned: bool) -> Cycle:
    """Resample both series, with orientations where the tool is turned, at the stamps that the reference covers."""
    first, last = int(reference.stamp[0]), int(reference.stamp[-1])
    # A range, which cuts without a copy: stamps increase.
    inside = slice(int(np.searchsorted(pose.stamp, first)), int(np.searchsorted(pose.stamp, last, side="right")))
    if inside.start == inside.stop:
        raise InputError(
            f"tool_pose has stamps from {pose.stamp[0] * 1e-9:.3f} to {pose.stamp[-1] * 1e-9:.3f} s and tool_reference "
            f"from {first * 1e-9:.3f} to {last * 1e-9:.3f} s: they must share a time; check the clocks of the recording"
        )
    stamp = pose.stamp[inside]
    # Relative to the first stamp, because a double does not hold nanoseconds since 1970.
    at, known = elapsed_seconds(stamp, first), elapsed_seconds(reference.stamp, first)
    attained = pose.position[inside]
    if np.array_equal(stamp, reference.stamp):
        commanded = reference.position
    else:
        commanded = np.empty((len(at), 3))
        for i in range(3):
            commanded[:, i] = np.interp(at, known, reference.position[:, i])
    for name, values in (("tool_pose", attained), ("tool_reference", commanded)):
        if not np.all(np.isfinite(values)):
            row = int(np.flatnonzero(~np.all(np.isfinite(values), axis=1))[0])
            raise InputError(
                f"{name} has a position that is not finite near {(stamp[row] - start) * 1e-9:.4f} s after the start: "
                "every position must be a number [m]; cut the log or repair the recording"
            )
    orientations = _orientations(pose.orientation[inside], reference.orientation, at, known) if turned else (None, None)
    return Cycle(elapsed_seconds(stamp, start), commanded, attained, *orientations)


def _orientations(
    attained: FloatArray, quaternion: FloatArray, at: FloatArray, known: FloatArray
) -> tuple[FloatArray | None, FloatArray | None]:
    """Resample both orientations; None where either is not a rotation or the command is identity."""
    if not _are_rotations(quaternion) or not _are_rotations(attained):
        return None, None
    if max(float(np.max(quaternion[:, :3])), -float(np.min(quaternion[:, :3]))) < 1e-9 or len(known) < 2:
        return None, None
    commanded = np.empty((len(at), 4))
    for start in range(0, len(at), AT_ONCE):
        times = at[start : start + AT_ONCE]
        # The samples around these times, the one before included where a time is that of a sample.
        begin = max(int(np.searchsorted(known, times[0])) - 1, 0)
        around = slice(begin, max(int(np.searchsorted(known, times[-1])), begin + 1) + 1)
        between = Slerp(known[around], Rotation.from_quat(quaternion[around]))
        commanded[start : start + AT_ONCE] = between(times).as_quat()
    # Both in the same half of the quaternion sphere as their neighbours, so that rows can be interpolated.
    return _continuous(commanded), _continuous(attained)


def _are_rotations(quaternion: FloatArray) -> bool:
    """Whether all quaternions are near unit length; a sender without orientation leaves zeros."""
    parts = np.array_split(quaternion, 1 + len(quaternion) // AT_ONCE)
    return all(bool(np.all(np.isfinite(part)) and np.all(np.linalg.norm(part, axis=1) >= 0.5)) for part in parts)


def _continuous(quaternion: FloatArray) -> FloatArray:
    """Turn the signs; the same array where none turns."""
    n = 1 + len(quaternion) // AT_ONCE
    pairs = zip(np.array_split(quaternion[1:], n), np.array_split(quaternion[:-1], n), strict=True)
    flips = np.concatenate([np.sum(after * before, axis=1) < 0.0 for after, before in pairs])
    if not np.any(flips):
        return quaternion
    sign = np.concatenate([[1.0], np.cumprod(np.where(flips, -1.0, 1.0))])
    return np.asarray(quaternion * sign[:, None], dtype=np.float64)


def _moving_axes(run: Cycle) -> tuple[str, ...]:
    span = np.maximum(np.ptp(run.commanded, axis=0), np.ptp(run.attained, axis=0))
    offset = np.array([np.max(np.abs(run.attained[:, i] - run.commanded[:, i])) for i in range(3)])
    moving = tuple(axis for axis, size in zip(AXES, np.maximum(span, offset), strict=True) if size > 1e-12)
    return moving or AXES


def _angle(run: Cycle) -> FloatArray | None:
    if run.commanded_orientation is None or run.attained_orientation is None:
        return None
    n = 1 + len(run.time) // AT_ONCE
    pairs = zip(np.array_split(run.commanded_orientation, n), np.array_split(run.attained_orientation, n), strict=True)
    angles = [(Rotation.from_quat(actual) * Rotation.from_quat(goal).inv()).magnitude() for goal, actual in pairs]
    return np.asarray(np.concatenate(angles), dtype=np.float64)
