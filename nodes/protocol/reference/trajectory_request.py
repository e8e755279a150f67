"""Whether a trajectory that a user sends can be followed, and the way to rest; free of ROS."""

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
"""Most points of a trajectory, chosen: more is taken for a mistake."""


class Refusal(Enum):
    """What is wrong with a trajectory."""

    JOINTS = auto()
    POINTS = auto()
    TOO_LATE = auto()


class RefusedTrajectoryError(RunError):
    """A trajectory that cannot be followed; whatever was followed before goes on.

    Args:
        text: What is wrong, what is allowed and what to do.
        refusal: The same for programs.
    """

    def __init__(self, text: str, refusal: Refusal) -> None:
        super().__init__(text)
        self.refusal = refusal


def in_joint_order(trajectory: JointTrajectoryChunk, names: Sequence[str]) -> JointTrajectoryChunk:
    """Bring the joints of a trajectory into the order of the motors.

    Args:
        trajectory: It names every joint once, in any order.
        names: Joint names in the order of the motors.

    Raises:
        RefusedTrajectoryError: A joint is missing, unknown or named twice.
    """
    if sorted(trajectory.names) != sorted(names):
        raise RefusedTrajectoryError(
            f"its joints are {', '.join(trajectory.names) or 'not named'}; allowed is each of {', '.join(names)}, once",
            Refusal.JOINTS,
        )
    return trajectory.in_order(names)


def check_points(trajectory: JointTrajectoryChunk, now: int, position_limit: float = np.inf) -> None:
    """Check times and values.

    Args:
        trajectory: Points in order of time; a stamp of 0 means from now on.
        now: Stamp of the newest sample [ns].
        position_limit: Largest position either way [rad or m].

    Raises:
        RefusedTrajectoryError: It cannot be followed.
    """
    times = trajectory.time_from_start
    if problem := _problem(trajectory, position_limit):
        raise RefusedTrajectoryError(problem, Refusal.POINTS)
    if trajectory.stamp_ns and trajectory.stamp_ns + int(times[-1]) < now:
        end = (trajectory.stamp_ns + int(times[-1])) / NANOSECONDS
        raise RefusedTrajectoryError(
            f"it ends at {end:.4f} s of simulated time, which is over: it is {now / NANOSECONDS:.4f} s; give a later "
            "header.stamp, or 0 for now",
            Refusal.TOO_LATE,
        )


def _problem(trajectory: JointTrajectoryChunk, position_limit: float) -> str:
    times = trajectory.time_from_start
    if len(times) == 0:
        return "it has no points; give at least one"
    if len(times) > MOST_POINTS:
        return f"it has {len(times)} points, allowed are {MOST_POINTS}; send fewer, what lies between is interpolated"
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        return "its times do not increase from 0 on; sort the points by time_from_start"
    if trajectory.positions is None:
        return "it has no positions; fill positions in every point"
    for field in ("positions", "velocities", "effort"):
        values = getattr(trajectory, field)
        if values is not None and not np.isfinite(values).all():
            point, joint = np.argwhere(~np.isfinite(values))[0]
            where = f"points[{point}].{field} of {trajectory.names[joint]}"
            return f"{where} is {values[point, joint]}, allowed is a finite number"
    if (farthest := np.abs(trajectory.positions)).max() > position_limit:
        point, joint = np.unravel_index(farthest.argmax(), farthest.shape)
        return (
            f"points[{point}].positions of {trajectory.names[joint]} is {trajectory.positions[point, joint]:g}, "
            f"allowed is up to {position_limit:g} either way (parameter position_limit); is it in rad or m?"
        )
    return ""


def way_to_rest(row: FloatArray, time: float) -> FloatArray:
    """Give the reference at which a motion comes to rest that slows down evenly.

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
