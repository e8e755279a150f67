"""Fastest profile of the speed along a path, by reachability analysis on a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.time_optimal.path_dynamics import PathDynamics

PASSES = 60
"""Largest number of passes in which the viscous torque is brought into agreement with the speed (chosen)."""

KEPT = 0.05
"""Least share of the squared speed that is left at the next grid point, so that the motion stops at its end alone."""

AGREEMENT = 1e-6
"""Relative change of the squared speed between two passes that counts as agreement (chosen)."""


@dataclass(frozen=True, eq=False)
class FastestProfile:
    """Speed along a path, with constant acceleration between the grid points.

    Attributes:
        grid: Shares sigma of the path, shape (n,).
        squared_pace: sigma'^2 at the grid points [1/s^2], shape (n,).
        acceleration: sigma'' between them [1/s^2], shape (n - 1,).
    """

    grid: FloatArray
    squared_pace: FloatArray
    acceleration: FloatArray

    @property
    def time(self) -> FloatArray:
        """Times of the grid points [s], shape (n,)."""
        pace = np.sqrt(self.squared_pace)
        return np.concatenate(([0.0], np.cumsum(2.0 * np.diff(self.grid) / (pace[1:] + pace[:-1]))))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return float(self.time[-1])

    def use(self, dynamics: PathDynamics) -> FloatArray:
        """Return how far each limit is used in each interval, 1 at the limit, shape (n - 1, M + 1).

        The torque counts from the one at rest, so that 0 is no motion; the last column is the speed.
        """
        pace = np.sqrt(self.squared_pace)
        ends = []
        for rows in (slice(None, -1), slice(1, None)):
            acceleration = np.zeros(self.grid.size)
            acceleration[rows] = self.acceleration
            whole = dynamics.torque(pace, acceleration)[rows] - dynamics.static[rows]
            room = np.where(whole > 0.0, dynamics.upper[rows], dynamics.lower[rows]) - dynamics.static[rows]
            ends.append(np.column_stack((np.abs(whole / room), pace[rows] / dynamics.largest_pace[rows])))
        return np.asarray(np.maximum(*ends))


def fastest_profile(dynamics: PathDynamics) -> FastestProfile:
    """Compute the fastest motion along a path from rest to rest within the limits.

    With x = sigma'^2 and u = sigma'' every torque is affine in (u, x), apart from the viscous one, and x' = 2 u between
    grid points. A pass from the end finds the largest x from which rest at the end can be reached; a pass from the
    start then takes the largest u that stays below it (Pham and Pham 2018, TOPP-RA). All limits hold on both sides of
    every grid point. The viscous torque v sqrt(x) is v x / sqrt(x_0) with x_0 of the pass before, repeated until both
    agree. At rest all limits must hold anywhere on the path, so the set of speeds at a point begins at 0.

    Args:
        dynamics: Torques and limits on the path.

    Returns:
        The profile.

    Raises:
        InputError: A motor cannot hold the arm somewhere on the path, or nothing limits the motion.
    """
    _check_holding(dynamics)
    profile = _one_pass(dynamics, np.zeros_like(dynamics.viscous))
    if not np.any(dynamics.viscous):
        return profile
    for _ in range(PASSES):
        before = profile.squared_pace
        pace = np.sqrt(np.maximum(before, 1e-6 * before.max()))
        profile = _one_pass(dynamics, dynamics.viscous / pace[:, None])
        if np.max(np.abs(profile.squared_pace - before)) <= AGREEMENT * before.max():
            break
    return profile


def _one_pass(dynamics: PathDynamics, viscous: FloatArray) -> FastestProfile:
    """Solve the problem with the viscous torque `viscous` times x, shape (n, M)."""
    step = np.diff(dynamics.grid)
    rows = _Rows.of(dynamics, viscous, step)
    largest = rows.largest(dynamics)
    n = dynamics.grid.size
    reachable = np.zeros(n)
    for i in range(n - 2, -1, -1):
        slope = -0.5 / step[i]
        steeper = rows.low_slope[i] > slope
        bound = (reachable[i + 1] / (2.0 * step[i]) - rows.low[i]) / np.where(steeper, rows.low_slope[i] - slope, 1.0)
        reachable[i] = min(largest[i], float(np.min(np.where(steeper, bound, np.inf))))
        if not np.isfinite(reachable[i]):
            raise InputError(
                f"nothing limits the motion: {', '.join(dynamics.names)} have neither torque nor speed limits; give "
                "torque_limit or speed_limit in the robot file or in the time law"
            )
        if i < n - 2:
            reachable[i] = min(reachable[i], reachable[i + 1] / KEPT)
    x, u = np.zeros(n), np.zeros(n - 1)
    for i in range(n - 1):
        most = float(np.min(rows.high[i] + rows.high_slope[i] * x[i]))
        u[i] = min(most, (reachable[i + 1] - x[i]) / (2.0 * step[i]))
        x[i + 1] = min(max(x[i] + 2.0 * step[i] * u[i], 0.0), reachable[i + 1])
    if np.any(x[1:-1] <= 0.0):
        where = 100 * dynamics.grid[1:-1][x[1:-1] <= 0.0][0]
        raise InputError(f"the torque limits leave no motion at {where:.3g} % of the path; raise them, or torque_share")
    return FastestProfile(dynamics.grid, x, 0.5 * np.diff(x) / step)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Bounds of the acceleration in each interval, low + low_slope x <= u <= high + high_slope x, shapes (n - 1, 2 M).

    `direct` bounds x where the acceleration has no influence, shape (n - 1,).
    """

    low: FloatArray
    low_slope: FloatArray
    high: FloatArray
    high_slope: FloatArray
    direct: FloatArray

    @classmethod
    def of(cls, dynamics: PathDynamics, viscous: FloatArray, step: FloatArray) -> _Rows:
        slope = dynamics.centrifugal + viscous
        start, end = slice(None, -1), slice(1, None)
        a = np.hstack((dynamics.inertia[start], dynamics.inertia[end] + 2.0 * step[:, None] * slope[end]))
        b = np.hstack((slope[start], slope[end]))
        up = np.hstack([(dynamics.upper - dynamics.static)[part] for part in (start, end)])
        down = np.hstack([(dynamics.lower - dynamics.static)[part] for part in (start, end)])
        weak = np.abs(a) <= 1e-9 * np.max(np.abs(a), axis=0)
        positive = a > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            high, low = np.where(positive, up, down) / a, np.where(positive, down, up) / a
            direct = np.where(weak & (b != 0.0), np.where(b > 0.0, up, down) / b, np.inf)
            line = -b / a
        high, low = np.where(weak, np.inf, high), np.where(weak, -np.inf, low)
        line = np.where(weak, 0.0, line)
        return cls(low, line, high, line, np.min(direct, axis=1))

    def largest(self, dynamics: PathDynamics) -> FloatArray:
        """Return the largest x at the start of each interval for which some u is allowed, shape (n - 1,)."""
        step = np.diff(dynamics.grid)[:, None]
        limit = dynamics.largest_pace**2
        gap = self.high[:, :, None] - self.low[:, None, :]
        closing = self.low_slope[:, None, :] - self.high_slope[:, :, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            pairs = np.where(closing > 0.0, gap / closing, np.inf).min(axis=(1, 2))
            slowing = -0.5 * (1.0 - np.where(np.arange(len(step)) < len(step) - 1, KEPT, 0.0))[:, None] / step
            stop = np.where(slowing > self.high_slope, self.high / (slowing - self.high_slope), np.inf)
        x = np.minimum(np.minimum(pairs, stop.min(axis=1)), self.direct)
        return np.asarray(np.minimum(x, limit[:-1]))


def _check_holding(dynamics: PathDynamics) -> None:
    room = np.minimum(dynamics.upper - dynamics.static, dynamics.static - dynamics.lower)
    point, motor = np.unravel_index(np.argmin(room), room.shape)
    if room[point, motor] <= 0.0:
        raise InputError(
            f"{dynamics.names[motor]} needs {dynamics.static[point, motor]:.4g} to hold the arm at "
            f"{100 * dynamics.grid[point]:.3g} % of the path, allowed is {dynamics.lower[point, motor]:.4g} to "
            f"{dynamics.upper[point, motor]:.4g}; raise torque_limit or torque_share, or move the path"
        )
