"""Reference held by the controller: appended chunks or a replacing trajectory."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, read_joint_trajectory
from flexros.logs.messages.trajectory_rows import TrajectoryRows
from flexros.logs.stamps import START_NS, stamp_of
from flexros_nodes.protocol.reference.link_columns import links_of
from flexros_nodes.protocol.reference.point_trajectory import PointTrajectory
from flexros_nodes.protocol.reference.trajectory_request import (
    RejectedTrajectoryError,
    Rejection,
    check_points,
    rest_row,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

MOST_ROWS = 500_000
"""Largest number of samples held ahead of the loop, chosen: more is taken for a mistake."""


class ReferenceBuffer:
    """Reference by stamp; a row is [motor position (M), velocity (M), feedforward torque (M)], then the links (5 M).

    Args:
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].
        link_motion: Whether the rows hold the motion of the links, which only chunks have.
        links_as_motors: Whether the links may be taken to move as the motors, where a trajectory tells no more.

    Attributes:
        current: Reference used last, shape (3 M or 8 M,); None before the first sample.
        pending: Trajectory to follow from the next sample on; None where there is none.
        ignored: Chunks dropped because a replacing trajectory is active.
    """

    def __init__(
        self, n_motors: int, sample_time: float, *, link_motion: bool = False, links_as_motors: bool = False
    ) -> None:
        self.ignored = 0
        self._link_motion = link_motion
        self._refuses_points = link_motion and not links_as_motors
        self._n_motors = n_motors
        self._sample_time = sample_time
        self._rows: dict[int, FloatArray] = {}
        self._order: deque[int] = deque()
        self._chunks: deque[TrajectoryRows] = deque()
        self._used = -1
        self.current: FloatArray | None = None
        self._trajectory: PointTrajectory | None = None
        self.pending: JointTrajectoryChunk | None = None

    def __len__(self) -> int:
        step = self._sample_time * 1e9
        ahead = max((chunk.last for chunk in self._chunks), default=self._used)
        return len(self._rows) + max(round((ahead - max(self._used, START_NS - round(step))) / step), 0)

    def append(self, chunk: JointTrajectoryChunk) -> None:
        """Append the samples of a chunk, except samples already used or held.

        Args:
            chunk: One point per sampling instant, with positions; columns in the order of the motors.

        Raises:
            RunError: A point is between two sampling instants, a value is not finite, positions are missing, or the
                buffer exceeds MOST_ROWS.
        """
        if self._trajectory is not None or self.pending is not None:
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
        self._check_number()

    def _check_number(self) -> None:
        if len(self) > MOST_ROWS:
            raise RunError(
                f"joint_reference_ahead is {len(self)} samples ahead of the loop, allowed are {MOST_ROWS}; "
                "stream it later, or send a trajectory of few points to joint_trajectory"
            )

    def append_message(self, message: bytes, names: Sequence[str]) -> int:
        """Append the samples of a serialised chunk, without decoding them yet where its form permits it.

        Args:
            message: Serialised trajectory_msgs/JointTrajectory.
            names: Names of its columns, of the motors and perhaps the links.

        Returns:
            Its stamp [ns].

        Raises:
            MessageError: The bytes are not a chunk for these joints.
            RunError: As `append`.
        """
        if not self._link_motion and self._trajectory is None and self.pending is None:
            with suppress(MessageError):
                self._chunks.append(TrajectoryRows(message, names, self._sample_time))
                self._check_number()
                return stamp_of(message)
        chunk = read_joint_trajectory(message).in_order(names)
        self.append(chunk)
        return chunk.stamp_ns

    def _row_of(self, stamp: int) -> FloatArray | None:
        """Return the row of a stamp [ns] from the chunks; None where none holds it."""
        if (row := self._rows.pop(stamp, None)) is not None:
            return row
        try:
            for chunk in self._chunks:
                if (row := chunk.row(stamp)) is not None:
                    return row
        except MessageError as error:
            raise RunError(f"a message on joint_reference_ahead is rejected: {error}") from error
        return None

    def replace(self, trajectory: JointTrajectoryChunk, position_limit: float = np.inf) -> None:
        """Drop the held samples and follow this trajectory from the next sample on; its last point is held.

        `PointTrajectory` interpolates between points. The motion to the first point starts at the present reference, or
        at the measured position where there is no reference yet.

        Args:
            trajectory: Points in order of time; a stamp of 0 means from now on.
            position_limit: Largest position either way [rad or m].

        Raises:
            RejectedTrajectoryError: The trajectory is invalid; the held samples remain.
        """
        self.check(trajectory, position_limit)
        self._rows.clear()
        self._order.clear()
        self._chunks.clear()
        self.pending = trajectory

    def check(self, trajectory: JointTrajectoryChunk, position_limit: float) -> None:
        """Raise RejectedTrajectoryError where `replace` would."""
        if self._refuses_points:
            raise RejectedTrajectoryError(
                "the controller follows the motion of the links and its derivatives, which a trajectory does not hold; "
                "use pid, cascade, gravity_pd or computed_torque",
                Rejection.POINTS,
            )
        check_points(trajectory, self._used, position_limit)

    @property
    def trajectory_end(self) -> int:
        """Stamp of the last point of the active trajectory [ns]; 0 where there is none."""
        return 0 if self._trajectory is None else self._trajectory.end

    def come_to_rest(self, time: float) -> None:
        """Decelerate evenly from the present reference to rest.

        Args:
            time: Time in which the reference comes to rest [s].
        """
        if self.current is not None and not self._refuses_points:
            n = self._n_motors
            position, velocity, effort = rest_row(self.current[: 3 * n], time).reshape(3, 1, n)
            duration = np.array([round(time * 1e9)])
            self.replace(JointTrajectoryChunk(0, ("",) * n, duration, position, velocity, None, effort))

    def take(self, stamp: int, measured: Sequence[float] | None = None) -> FloatArray | None:
        """Return the reference of a stamp [ns], shape (3 M or 8 M,); None if it is not held.

        Older samples are dropped, also those that a real-time loop has skipped.

        Args:
            stamp: The stamp [ns].
            measured: Measured motor positions [rad or m], start of a first trajectory.
        """
        if self.pending is not None:
            self._start_trajectory(self.pending, measured)
        if self._trajectory is not None:
            row = self._trajectory.row(stamp) if stamp > self._used else None
        else:
            row = self._row_of(stamp)
        self._drop_until(stamp)
        if row is not None:
            self._used = stamp
            self.current = row
        return row

    def _start_trajectory(self, given: JointTrajectoryChunk, measured: Sequence[float] | None) -> None:
        self.pending = None
        now = max(self._used, START_NS)
        times = ((given.stamp_ns or now) + given.time_from_start).astype(np.int64)
        rows, before = self._of_motors(given), None if self.current is None else self.current[: 3 * self._n_motors]
        if before is None and measured is not None:
            before = np.array([*measured, *[0.0] * (2 * self._n_motors)])
        if before is not None and times[0] > now:
            times, rows = np.concatenate([[now], times]), np.vstack([before, rows])
        self._trajectory = PointTrajectory(times, rows, smooth=given.velocities is not None, links=self._link_motion)

    def _drop_until(self, stamp: int) -> None:
        order, chunks = self._order, self._chunks
        while chunks and chunks[0].last <= stamp:
            chunks.popleft()
        while order and order[0] <= stamp:
            self._rows.pop(order.popleft(), None)
        if self._used < stamp - 1:
            self._used = stamp - 1

    def _filled(self, chunk: JointTrajectoryChunk) -> FloatArray:
        rows = self._of_motors(chunk)
        if not self._link_motion:
            return rows
        assert chunk.positions is not None
        velocities = np.zeros_like(chunk.positions) if chunk.velocities is None else chunk.velocities
        return _finite(np.hstack([rows, links_of(chunk.positions, velocities, self._n_motors)]))

    def _of_motors(self, chunk: JointTrajectoryChunk) -> FloatArray:
        """Return position, velocity and torque of the motors, shape (n, 3 M)."""
        if chunk.positions is None:
            raise RunError("a reference trajectory has no positions; fill positions in every point")
        zeros = np.zeros_like(chunk.positions)
        velocities = zeros if chunk.velocities is None else chunk.velocities
        effort = zeros if chunk.effort is None else chunk.effort
        m = self._n_motors
        return _finite(np.hstack([chunk.positions[:, :m], velocities[:, :m], effort[:, :m]]))


def _finite(rows: FloatArray) -> FloatArray:
    if not np.isfinite(rows).all():
        raise RunError("a reference trajectory has a value that is not a finite number; correct its sender")
    return rows
