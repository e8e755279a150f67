"""The reference that a controller holds: chunks that append, trajectories that replace; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import RunError
from flexros.logs.stamps import START_NS, sample_number, stamp_ns

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.joint_trajectory_message import JointTrajectoryChunk


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
        self._used = -1
        self._current: FloatArray | None = None
        self._final: tuple[int, FloatArray] | None = None

    def __len__(self) -> int:
        return len(self._rows)

    def append(self, chunk: JointTrajectoryChunk) -> None:
        """Add the samples of a chunk; samples already used or held are not added twice.

        Args:
            chunk: One point for each sampling instant, with positions; columns in the order of the motors.

        Raises:
            RunError: A point lies between two sampling instants, a value is not finite, or positions are missing.
        """
        if self._final is not None:
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
        fresh = slice(int(np.searchsorted(stamps, self._used, side="right")), None)
        self._rows.update(zip(stamps[fresh].tolist(), rows[fresh], strict=True))

    def replace(self, trajectory: JointTrajectoryChunk) -> None:
        """Drop what is held and follow this trajectory; its end is held.

        Between two points the position is the cubic that fits positions and velocities, or a straight line when the
        points carry no velocities; torques are interpolated linearly. Before the first point the way leads from the
        present reference.

        Args:
            trajectory: Points in order of time; a stamp of 0 means from now on.

        Raises:
            RunError: Times do not increase, a value is not finite, or positions are missing.
        """
        rows = self._filled(trajectory)
        now = max(self._used, stamp_ns(0, self._sample_time))
        origin = trajectory.stamp_ns or now
        times = (origin + trajectory.time_from_start).astype(np.int64)
        if len(times) == 0 or np.any(np.diff(times) <= 0):
            raise RunError("a trajectory on joint_trajectory has no points, or times that do not increase; correct it")
        smooth = trajectory.velocities is not None
        if self._current is not None and times[0] > now:
            times, rows = np.concatenate([[now], times]), np.vstack([self._current, rows])
        first, last = sample_number(int(now), self._sample_time) + 1, sample_number(int(times[-1]), self._sample_time)
        numbers = range(first, last + 1)
        stamps = np.array([stamp_ns(k, self._sample_time) for k in numbers], dtype=np.int64)
        sampled = _interpolate(stamps, times, rows, self._n_motors, smooth=smooth)
        self._rows = dict(zip(stamps.tolist(), sampled, strict=True))
        rest = rows[-1].copy()
        rest[self._n_motors : 2 * self._n_motors] = 0.0
        self._final = (int(times[-1]), rest)

    def take(self, stamp: int) -> FloatArray | None:
        """Hand out the reference of a stamp [ns], shape (3 M,); None if it is not held. Older ones are forgotten."""
        row = self._rows.pop(stamp, None)
        if row is None:
            if self._final is None or stamp < self._final[0]:
                return None
            row = self._final[1]
        self._used = stamp
        self._current = row
        return row

    def forget_before(self, stamp: int) -> None:
        """Drop what a real-time loop has passed without using it [ns]."""
        self._used = max(self._used, stamp - 1)
        self._rows = {held: row for held, row in self._rows.items() if held >= stamp}

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


def _interpolate(at: IntArray, times: IntArray, rows: FloatArray, n_motors: int, *, smooth: bool) -> FloatArray:
    """Evaluate the points at stamps [ns]; outside the points the nearest one holds at rest."""
    if len(times) == 1:
        sampled = np.repeat(rows, len(at), axis=0)
        sampled[:, n_motors : 2 * n_motors] = 0.0
        return sampled
    i = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    width = ((times[i + 1] - times[i]) * 1e-9)[:, None]
    s = np.clip((at - times[i])[:, None] * 1e-9 / width, 0.0, 1.0)
    inside = ((at >= times[0]) & (at <= times[-1]))[:, None]
    before, after = rows[i], rows[i + 1]
    p0, p1 = before[:, :n_motors], after[:, :n_motors]
    torque = before[:, 2 * n_motors :] + s * (after - before)[:, 2 * n_motors :]
    if not smooth:
        return np.hstack([p0 + s * (p1 - p0), inside * (p1 - p0) / width, torque])
    v0, v1 = (width * row[:, n_motors : 2 * n_motors] for row in (before, after))
    position = (
        (2 * s**3 - 3 * s**2 + 1) * p0 + (s**3 - 2 * s**2 + s) * v0 + (3 * s**2 - 2 * s**3) * p1 + (s**3 - s**2) * v1
    )
    velocity = ((6 * s**2 - 6 * s) * (p0 - p1) + (3 * s**2 - 4 * s + 1) * v0 + (3 * s**2 - 2 * s) * v1) / width
    return np.hstack([position, inside * velocity, torque])
