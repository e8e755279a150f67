"""Path performance of repeated cycles after ISO 9283:1998: path accuracy, path repeatability, path velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.cycles import Cycle
    from flexros.arrays import BoolArray, FloatArray

STANDARD_CYCLES = 10
"""Number of cycles that the standard requires."""
POINTS = 200
"""Number of points along the path that are evaluated (chosen)."""
_SAME_PLACE = 1e-9
"""Rounding of positions [m]."""


@dataclass(frozen=True)
class PathVelocity:
    """Path velocity on the part of the path that is commanded at constant speed (ISO 9283, 8.6).

    Attributes:
        commanded: Commanded speed v_c [m/s].
        accuracy: AV = (mean attained speed - v_c) / v_c, dimensionless.
        repeatability: RV = 3 S_v / v_c, dimensionless; None with one cycle.
    """

    commanded: float
    accuracy: float
    repeatability: float | None


@dataclass(frozen=True, eq=False)
class PathPerformance:
    """Path accuracy and repeatability over n cycles at m points of the commanded path (ISO 9283, 8.2 and 8.3).

    Attributes:
        cycles: Number of cycles n.
        points: Number of points m of the commanded path that were evaluated.
        position_accuracy: AT_p, largest distance of the mean attained path from the commanded path [m].
        position_repeatability: RT_p, largest mean + 3 S of the distance from the mean path [m]; None with n = 1.
        orientation_accuracy: AT_a, AT_b, AT_c, largest mean error about x, y, z [rad], shape (3,); None where no
            orientation is commanded.
        orientation_repeatability: RT_a, RT_b, RT_c, largest 3 S about x, y, z [rad], shape (3,); None with n = 1 or
            where no orientation is commanded.
        velocity: Path velocity; None where no part of the path has constant speed.
        position: Distance along the path of the points evaluated [m], shape (m,).
        accuracy_along: Distance of the mean attained path from the commanded path at each point [m], shape (m,).
        repeatability_along: Mean + 3 S of the distance from the mean path [m], shape (m,); None with n = 1.
    """

    cycles: int
    points: int
    position_accuracy: float
    position_repeatability: float | None
    orientation_accuracy: FloatArray | None
    orientation_repeatability: FloatArray | None
    velocity: PathVelocity | None
    position: FloatArray
    accuracy_along: FloatArray
    repeatability_along: FloatArray | None

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain numbers with their units in the keys."""
        velocity = self.velocity
        return {
            "cycles": self.cycles,
            "points": self.points,
            "AT_p_m": self.position_accuracy,
            "RT_p_m": self.position_repeatability,
            "AT_abc_rad": None if self.orientation_accuracy is None else self.orientation_accuracy.tolist(),
            "RT_abc_rad": None if self.orientation_repeatability is None else self.orientation_repeatability.tolist(),
            "commanded_speed_m_per_s": None if velocity is None else velocity.commanded,
            "AV": None if velocity is None else velocity.accuracy,
            "RV": None if velocity is None else velocity.repeatability,
        }


@dataclass(frozen=True, eq=False)
class _Crossings:
    """Crossings of the attained path of a cycle with the planes normal to the commanded path; NaN where none."""

    time: FloatArray
    position: FloatArray
    commanded: FloatArray
    rotation: FloatArray | None


def path_performance(cycles: Sequence[Cycle], points: int = POINTS) -> PathPerformance:
    """Evaluate path accuracy, repeatability and velocity over repeated cycles of one path.

    At each of m points P_i of the commanded path the attained path of cycle j is cut by the plane through P_i normal to
    the path, which gives Z_ij (ISO 9283:1998, 8.2, 8.3):
    AT_p = max_i |mean_j Z_ij - P_i|; RT_p = max_i (mean_j l_ij + 3 S_i), l_ij = |Z_ij - mean_j Z_ij|.

    Args:
        cycles: Passes of the same commanded path, from one log or from several, at least one.
        points: Number of points evaluated, spread evenly along the path.

    Returns:
        The figures. The standard requires 10 cycles; fewer are evaluated as well, and their number is reported.

    Raises:
        InputError: The cycles do not follow the same path, or the path does not move.
    """
    length = [float(cycle.arc_length()[-1]) for cycle in cycles]
    if length[0] <= 0.0 or max(length) - min(length) > 0.01 * length[0]:
        raise InputError(
            f"cycles with commanded paths of {min(length):.6g} to {max(length):.6g} m were given for path performance: "
            "all must be passes of one moving path; compare different paths with a report instead"
        )
    # Without the ends, whose normal planes the attained path need not reach.
    position = length[0] * (np.arange(points) + 0.5) / points
    crossings = [_crossings(cycle, position) for cycle in cycles]
    attained = np.stack([c.position for c in crossings])
    valid = np.all(np.isfinite(attained), axis=(0, 2))
    if not np.any(valid):
        raise InputError(
            "tool_pose crosses no plane normal to the commanded path, so it does not follow tool_reference: "
            "both must be of the same tool and in the same frame and unit [m]; check the recording"
        )
    attained = attained[:, valid]
    mean = attained.mean(axis=0)
    accuracy = np.linalg.norm(mean - crossings[0].commanded[valid], axis=1)
    spread = _repeatability(np.linalg.norm(attained - mean, axis=2))
    turn = _orientation(crossings, valid)
    return PathPerformance(
        cycles=len(cycles),
        points=int(np.count_nonzero(valid)),
        position_accuracy=float(np.max(accuracy)),
        position_repeatability=None if spread is None else float(np.max(spread)),
        orientation_accuracy=None if turn is None else np.max(np.abs(turn.mean(axis=0)), axis=0),
        orientation_repeatability=(
            None if turn is None or len(cycles) < 2 else np.max(3.0 * turn.std(axis=0, ddof=1), axis=0)
        ),
        velocity=_velocity(cycles),
        position=position[valid],
        accuracy_along=accuracy,
        repeatability_along=spread,
    )


def _repeatability(distance: FloatArray) -> FloatArray | None:
    if len(distance) < 2:
        return None
    return np.asarray(distance.mean(axis=0) + 3.0 * distance.std(axis=0, ddof=1), dtype=np.float64)


def _orientation(crossings: Sequence[_Crossings], valid: BoolArray) -> FloatArray | None:
    rotations = [c.rotation for c in crossings if c.rotation is not None]
    if len(rotations) < len(crossings):
        return None
    return np.stack(rotations)[:, valid]


def _crossings(cycle: Cycle, position: FloatArray) -> _Crossings:
    travelled = cycle.arc_length()
    moving = np.flatnonzero(np.diff(travelled) > 0.0)
    last = np.clip(np.searchsorted(travelled[moving], position, side="right") - 1, 0, len(moving) - 1)
    segment = moving[last]
    step = cycle.commanded[segment + 1] - cycle.commanded[segment]
    share = (position - travelled[segment]) / (travelled[segment + 1] - travelled[segment])
    commanded = cycle.commanded[segment] + share[:, None] * step
    tangent = step / np.linalg.norm(step, axis=1, keepdims=True)
    at = segment + share
    # A crossing farther away than the largest tool error belongs to another part of the path.
    reach = float(np.max(np.linalg.norm(cycle.attained - cycle.commanded, axis=1))) + _SAME_PLACE
    planes = zip(commanded, tangent, at, strict=True)
    index = np.array([_nearest_crossing(cycle, p, d, k, reach) for p, d, k in planes])
    samples = np.arange(len(cycle.time), dtype=np.float64)
    crossed = np.isfinite(index)
    attained = np.full_like(commanded, np.nan)
    attained[crossed] = _at(cycle.attained, index[crossed])
    time = np.where(crossed, np.interp(index, samples, cycle.time), np.nan)
    rotation = None
    if cycle.attained_orientation is not None and cycle.commanded_orientation is not None:
        rotation = np.full_like(commanded, np.nan)
        goal = Rotation.from_quat(_at(cycle.commanded_orientation, at[crossed]))
        rotation[crossed] = (
            Rotation.from_quat(_at(cycle.attained_orientation, index[crossed])) * goal.inv()
        ).as_rotvec()
    return _Crossings(time, attained, commanded, rotation)


def _nearest_crossing(cycle: Cycle, point: FloatArray, tangent: FloatArray, sample: float, reach: float) -> float:
    """Return the (fractional) sample nearest to `sample` where the attained path crosses the plane forward.

    Only crossings within `reach` of the point are used [m]; nan where there is none.
    """
    ahead = (cycle.attained - point) @ tangent
    crossing = np.flatnonzero((ahead[:-1] <= 0.0) & (ahead[1:] > 0.0))
    fraction = crossing - ahead[crossing] / (ahead[crossing + 1] - ahead[crossing])
    fraction = fraction[np.linalg.norm(_at(cycle.attained, fraction) - point, axis=1) <= reach]
    if len(fraction) == 0:
        return float("nan")
    return float(fraction[np.argmin(np.abs(fraction - sample))])


def _at(rows: FloatArray, index: FloatArray) -> FloatArray:
    """Interpolate rows linearly at fractional indices."""
    low = np.clip(index.astype(np.int64), 0, len(rows) - 2)
    share = (index - low)[:, None]
    return np.asarray((1.0 - share) * rows[low] + share * rows[low + 1], dtype=np.float64)


def _velocity(cycles: Sequence[Cycle]) -> PathVelocity | None:
    speeds = []
    commanded = 0.0
    for cycle in cycles:
        travelled = cycle.arc_length()
        speed = np.diff(travelled) / np.diff(cycle.time)
        cruise = np.flatnonzero(speed >= 0.999 * np.max(speed))
        first, last = int(cruise[0]), int(cruise[-1]) + 1
        if len(cruise) < last - first or last - first < max(10, len(speed) // 20):
            return None
        margin = 0.1 * (travelled[last] - travelled[first])
        ends = np.array([travelled[first] + margin, travelled[last] - margin])
        time = _crossings(cycle, ends).time
        commanded = float(np.mean(speed[first:last]))
        speeds.append((ends[1] - ends[0]) / (time[1] - time[0]))
    if not np.all(np.isfinite(speeds)):
        return None
    return PathVelocity(
        commanded=commanded,
        accuracy=float(np.mean(speeds) / commanded - 1.0),
        repeatability=float(3.0 * np.std(speeds, ddof=1) / commanded) if len(speeds) > 1 else None,
    )
