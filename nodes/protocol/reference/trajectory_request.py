"""Validation of trajectories sent by users, and the stopping motion."""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk

MOST_POINTS = 500_000
"""Largest number of points of a trajectory, chosen: more is taken for a mistake."""


class Rejection(Enum):
    """Reason to reject a trajectory."""

    JOINTS = auto()
    POINTS = auto()
    TOO_LATE = auto()


class RejectedTrajectoryError(RunError):
    """Invalid trajectory; the present reference remains in force.

    Args:
        text: What is wrong, what is allowed and what to do.
        reason: The reason for programs.
    """

    def __init__(self, text: str, reason: Rejection) -> None:
        super().__init__(text)
        self.reason = reason


def in_joint_order(trajectory: JointTrajectoryChunk, names: Sequence[str]) -> JointTrajectoryChunk:
    """Reorder the joints of a trajectory to the order of the motors.

    Args:
        trajectory: Trajectory that names every joint once, in any order.
        names: Joint names in the order of the motors.

    Raises:
        RejectedTrajectoryError: A joint is missing, unknown or named twice.
    """
    if sorted(trajectory.names) != sorted(names):
        raise RejectedTrajectoryError(
            f"its joints are {', '.join(trajectory.names) or 'not named'}; allowed is each of {', '.join(names)}, once",
            Rejection.JOINTS,
        )
    return trajectory.in_order(names)


def check_points(trajectory: JointTrajectoryChunk, now: int, position_limit: float = np.inf) -> None:
    """Check times and values of a trajectory.

    Args:
        trajectory: Points in order of time; a stamp of 0 means from now on.
        now: Stamp of the newest sample [ns].
        position_limit: Largest position either way [rad or m].

    Raises:
        RejectedTrajectoryError: The trajectory is invalid.
    """
    times = trajectory.time_from_start
    if problem := _problem(trajectory, position_limit):
        raise RejectedTrajectoryError(problem, Rejection.POINTS)
    if trajectory.stamp_ns and trajectory.stamp_ns + int(times[-1]) < now:
        end = (trajectory.stamp_ns + int(times[-1])) / NANOSECONDS
        raise RejectedTrajectoryError(
            f"it ends at {end:.4f} s of simulated time, in the past: it is {now / NANOSECONDS:.4f} s; give a later "
            "header.stamp, or 0 for now",
            Rejection.TOO_LATE,
        )


def _problem(trajectory: JointTrajectoryChunk, position_limit: float) -> str:
    times = trajectory.time_from_start
    if len(times) == 0:
        return "it has no points; give at least one"
    if len(times) > MOST_POINTS:
        return f"it has {len(times)} points, allowed are {MOST_POINTS}; send fewer, they are interpolated"
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        return "its times do not increase from 0 on; sort the points by time_from_start"
    if trajectory.positions is None:
        return "it has no positions; fill positions in every point"
    for field in ("positions", "velocities", "effort"):
        values = getattr(trajectory, field)
        if values is not None and not np.isfinite(values).all():
            point, joint = np.argwhere(~np.isfinite(values))[0]
            entry = f"points[{point}].{field} of {trajectory.names[joint]}"
            return f"{entry} is {values[point, joint]}, allowed is a finite number"
    if (magnitude := np.abs(trajectory.positions)).max() > position_limit:
        point, joint = np.unravel_index(magnitude.argmax(), magnitude.shape)
        return (
            f"points[{point}].positions of {trajectory.names[joint]} is {trajectory.positions[point, joint]:g}, "
            f"allowed is up to {position_limit:g} either way (parameter position_limit); is it in rad or m?"
        )
    return ""


def rest_row(row: FloatArray, time: float) -> FloatArray:
    """Return the reference at which a motion with constant deceleration comes to rest.

    Args:
        row: Present reference: position (M), velocity (M), torque (M), shape (3 M,).
        time: Time in which it comes to rest [s].

    Returns:
        The reference at rest, with the present torque, shape (3 M,).
    """
    n = len(row) // 3
    rest: FloatArray = row.copy()
    rest[:n] += 0.5 * time * row[n : 2 * n]
    rest[n : 2 * n] = 0.0
    return rest
