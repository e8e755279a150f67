"""The reference that a controller holds: chunks that append, trajectories that replace; free of ROS."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.logs.stamps import START_NS
from flexros_nodes.point_trajectory import PointTrajectory

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.logs.joint_trajectory_message import JointTrajectoryChunk

MOST_ROWS = 500_000
"""Most samples held ahead of the loop, and most points of a trajectory, chosen: more is taken for a mistake."""


class ReferenceBuffer:
    """Reference by stamp; a row is [motor position (M), velocity (M), feedforward torque (M)].

    Args:
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].

    Attributes:
        ignored: Appended chunks that came after a replacing trajectory and were left out.
    """

    def __init__(self, n_motors: int, sample_time: float) -> None:
        self.ignored = 0
        self._n_motors = n_motors
        self._sample_time = sample_time
        self._rows: dict[int, FloatArray] = {}
        self._order: deque[int] = deque()
        self._used = -1
        self._current: FloatArray | None = None
        self._trajectory: PointTrajectory | None = None

    def __len__(self) -> int:
        return len(self._rows)

    def append(self, chunk: JointTrajectoryChunk) -> None:
        """Add the samples of a chunk; samples already used or held are not added twice.

        Args:
            chunk: One point for each sampling instant, with positions; columns in the order of the motors.

        Raises:
            RunError: A point lies between two sampling instants, a value is not finite, positions are missing, or more
                is held than any loop needs.
        """
        if self._trajectory is not None:
            self.ignored += 1
            return
        stamps = chunk.stamp_ns + chunk.time_from_start
        rows = self._filled(chunk)
        number = np.rint((stamps - START_NS) / (self._sample_time * 1e9))
        between = stamps != START_NS + np.rint(number * self._sample_time * 1e9).astype(np.int64)
        if between.any():
            raise RunError(
                f"a chunk of joint_reference_ahead has a point at {stamps[between][0]} ns, between two sampling "
                f"instants of {self._sample_time:g} s; stream one point per sample or send it to joint_trajectory"
            )
        for stamp, row in zip(stamps.tolist(), rows, strict=True):
            if stamp > self._used and stamp not in self._rows:
                self._rows[stamp] = row
                self._order.append(stamp)
        if len(self._rows) > MOST_ROWS:
            raise RunError(
                f"joint_reference_ahead is {len(self._rows)} samples ahead of the loop, allowed are {MOST_ROWS}; "
                "stream it later, or send a trajectory of few points to joint_trajectory"
            )

    def replace(self, trajectory: JointTrajectoryChunk) -> None:
        """Drop what is held and follow this trajectory; its end is held.

        `PointTrajectory` tells what lies between two points. Before the first point the way leads from the present
        reference.

        Args:
            trajectory: Points in order of time; a stamp of 0 means from now on.

        Raises:
            RunError: Times do not increase, a value is not finite, positions are missing, or there are too many points.
        """
        times = trajectory.time_from_start
        if len(times) == 0 or np.any(np.diff(times) <= 0):
            raise RunError("a trajectory on joint_trajectory has no points, or times that do not increase; correct it")
        if len(times) > MOST_ROWS:
            raise RunError(
                f"a trajectory on joint_trajectory has {len(times)} points, allowed are {MOST_ROWS}; send fewer, "
                "what lies between them is interpolated"
            )
        rows = self._filled(trajectory)
        now = max(self._used, START_NS)
        times = ((trajectory.stamp_ns or now) + times).astype(np.int64)
        if self._current is not None and times[0] > now:
            times, rows = np.concatenate([[now], times]), np.vstack([self._current, rows])
        self._rows.clear()
        self._order.clear()
        self._trajectory = PointTrajectory(times, rows, smooth=trajectory.velocities is not None)

    def take(self, stamp: int) -> FloatArray | None:
        """Hand out the reference of a stamp [ns], shape (3 M,); None if it is not held.

        What is older is forgotten, also what a real-time loop has passed without using it.
        """
        if self._trajectory is not None:
            row = self._trajectory.row(stamp) if stamp > self._used else None
        else:
            row = self._rows.pop(stamp, None)
        self._forget_before(stamp)
        if row is not None:
            self._used = stamp
            self._current = row
        return row

    def _forget_before(self, stamp: int) -> None:
        order = self._order
        while order and order[0] <= stamp:
            self._rows.pop(order.popleft(), None)
        if self._used < stamp - 1:
            self._used = stamp - 1

    def _filled(self, chunk: JointTrajectoryChunk) -> FloatArray:
        if chunk.positions is None:
            raise RunError("a reference trajectory has no positions; fill positions in every point")
        nothing = np.zeros_like(chunk.positions)
        velocities = nothing if chunk.velocities is None else chunk.velocities
        effort = nothing if chunk.effort is None else chunk.effort
        rows = np.hstack([chunk.positions, velocities, effort])
        if not np.isfinite(rows).all():
            raise RunError("a reference trajectory has a value that is not a finite number; correct its sender")
        return rows
