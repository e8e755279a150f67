"""The reference that a controller holds: chunks that append, trajectories that replace; free of ROS."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
from flexros.logs.stamps import START_NS
from flexros_nodes.protocol.reference.point_trajectory import PointTrajectory
from flexros_nodes.protocol.reference.trajectory_request import check_points, way_to_rest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

MOST_ROWS = 500_000
"""Most samples held ahead of the loop, chosen: more is taken for a mistake."""


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
        self._next: JointTrajectoryChunk | None = None

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
        if self._trajectory is not None or self._next is not None:
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

    def replace(self, trajectory: JointTrajectoryChunk, position_limit: float = np.inf) -> None:
        """Drop what is held and follow this trajectory from the next sample on; its end is held.

        `PointTrajectory` tells what lies between two points. Before the first point the way leads from the present
        reference; where there is none as yet, from the measured position.

        Args:
            trajectory: Points in order of time; a stamp of 0 means from now on.
            position_limit: Largest position either way [rad or m].

        Raises:
            RefusedTrajectoryError: It cannot be followed; what was held remains.
        """
        check_points(trajectory, self._used, position_limit)
        self._rows.clear()
        self._order.clear()
        self._next = trajectory

    def check(self, trajectory: JointTrajectoryChunk, position_limit: float) -> None:
        """Refuse what `replace` would refuse."""
        check_points(trajectory, self._used, position_limit)

    @property
    def trajectory_end(self) -> int:
        """Stamp of the last point of the trajectory that is followed [ns]; 0 where there is none."""
        return 0 if self._trajectory is None else self._trajectory.end

    def come_to_rest(self, time: float) -> None:
        """Slow down evenly from the present reference, and stay where that ends.

        Args:
            time: Time in which the reference comes to rest [s].
        """
        if self._current is not None:
            n = self._n_motors
            position, velocity, effort = way_to_rest(self._current, time).reshape(3, 1, n)
            duration = np.array([round(time * 1e9)])
            self.replace(JointTrajectoryChunk(0, ("",) * n, duration, position, velocity, None, effort))

    def take(self, stamp: int, measured: Sequence[float] | None = None) -> FloatArray | None:
        """Hand out the reference of a stamp [ns], shape (3 M,); None if it is not held.

        What is older is forgotten, also what a real-time loop has passed without using it.

        Args:
            stamp: The stamp [ns].
            measured: Measured motor positions [rad or m], from which a first trajectory may lead.
        """
        if self._next is not None:
            self._begin_trajectory(self._next, measured)
        if self._trajectory is not None:
            row = self._trajectory.row(stamp) if stamp > self._used else None
        else:
            row = self._rows.pop(stamp, None)
        self._forget_before(stamp)
        if row is not None:
            self._used = stamp
            self._current = row
        return row

    def _begin_trajectory(self, given: JointTrajectoryChunk, measured: Sequence[float] | None) -> None:
        self._next = None
        now = max(self._used, START_NS)
        times = ((given.stamp_ns or now) + given.time_from_start).astype(np.int64)
        rows, before = self._filled(given), self._current
        if before is None and measured is not None:
            before = np.array([*measured, *[0.0] * (2 * self._n_motors)])
        if before is not None and times[0] > now:
            times, rows = np.concatenate([[now], times]), np.vstack([before, rows])
        self._trajectory = PointTrajectory(times, rows, smooth=given.velocities is not None)

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
