"""Trajectory of points, interpolated at one instant at a time."""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray


class PointTrajectory:
    """Interpolates positions, velocities and torques between points in time.

    Between two points the position follows the cubic that fits positions and velocities, or is linear when the points
    carry no velocities; torques are linear. Before the first and after the last point the reference is at rest there.
    Links, where they are wanted, move as the motors, with the acceleration of the cubic; jerk and snap are zero.

    Args:
        times: Increasing stamps of the points [ns], shape (p,).
        rows: Motor position (M), velocity (M), torque (M) of the points, shape (p, 3 M).
        smooth: Whether the points carry velocities.
        links: Whether the motion of the links is wanted too: position and four derivatives, M each.
    """

    def __init__(self, times: IntArray, rows: FloatArray, *, smooth: bool, links: bool = False) -> None:
        self._times: list[int] = times.tolist()
        self._rows = rows
        self._n_motors = rows.shape[1] // 3
        self._smooth = smooth
        self._links = links

    @property
    def end(self) -> int:
        """Stamp of the last point [ns]."""
        return self._times[-1]

    def row(self, stamp: int) -> FloatArray:
        """Return the reference at a stamp [ns], shape (3 M,) or, with links, (8 M,)."""
        times = self._times
        if stamp < times[0] or (stamp >= times[-1] and (stamp > times[-1] or len(times) == 1)):
            return self._at_rest(0 if stamp < times[0] else -1)
        i = min(bisect_right(times, stamp) - 1, len(times) - 2)
        width = (times[i + 1] - times[i]) * 1e-9
        s = (stamp - times[i]) * 1e-9 / width
        m = self._n_motors
        before, after = self._rows[i], self._rows[i + 1]
        step = after - before
        row: FloatArray = before + s * step
        if not self._smooth:
            row[m : 2 * m] = step[:m] / width
            return self._with_links(row, np.zeros(m))
        v0, v1 = width * before[m : 2 * m], width * after[m : 2 * m]
        bend, turn = v0 + v1 - 2.0 * step[:m], 3.0 * step[:m] - 2.0 * v0 - v1  # of s^3 and of s^2
        row[:m] = before[:m] + s * (v0 + s * (turn + s * bend))
        row[m : 2 * m] = (v0 + s * (2.0 * turn + 3.0 * s * bend)) / width
        return self._with_links(row, (2.0 * turn + 6.0 * s * bend) / width**2)

    def _at_rest(self, point: int) -> FloatArray:
        row: FloatArray = self._rows[point].copy()
        row[self._n_motors : 2 * self._n_motors] = 0.0
        return self._with_links(row, np.zeros(self._n_motors))

    def _with_links(self, row: FloatArray, acceleration: FloatArray) -> FloatArray:
        if not self._links:
            return row
        m = self._n_motors
        return np.concatenate([row, row[: 2 * m], acceleration, np.zeros(2 * m)])
