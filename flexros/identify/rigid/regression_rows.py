"""The decimated regression of one log, a stretch at a time: memory is bounded whatever the length of the log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.motion_estimate import MotionEstimate, decimate, decimation, edge, estimate_motion
from flexros.identify.rigid.record import RigidRecord, rigid_record

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flexros.arrays import FloatArray
    from flexros.identify.rigid.base_parameters import BaseParameters
    from flexros.identify.rigid.regressor import RigidRegressor
    from flexros.identify.rigid.settings import RigidSettings
    from flexros.logs.time_series import Log

_CHUNK_ROWS = 200
"""Decimated rows made at a time (chosen)."""

_KEPT_BYTES = 1_000_000_000
"""Largest regressor that is kept [bytes]; a larger one is evaluated anew when it is needed again (chosen: no more than
reading such a log takes)."""


@dataclass(frozen=True, eq=False)
class RegressionRows:
    """Regression tau = H pi_b of one log after low-pass and decimation.

    Attributes:
        record: What was taken from the log.
        motion: Its motion by zero-phase filtering.
        regressor: The regressor.
        leading: Columns of the regressor that count, one per base parameter, length r.
        cutoff: Corner of the low-pass for the positions [Hz].
        torque: Torques [Nm or N], shape (n, M).
        kept: Stretches of the regressor that were evaluated already; empty when it is too large to be kept.
    """

    record: RigidRecord
    motion: MotionEstimate
    regressor: RigidRegressor
    leading: tuple[int, ...]
    cutoff: float
    torque: FloatArray
    kept: list[FloatArray]

    @classmethod
    def of_log(
        cls, log: Log, settings: RigidSettings, label: str, regressor: RigidRegressor, base: BaseParameters
    ) -> RegressionRows:
        """Filter a log.

        Args:
            log: The log.
            settings: Cut-off, and how commands are paired with positions.
            label: Name of the log; opens error texts.
            regressor: The regressor.
            base: The base parameters.

        Raises:
            InputError: The log does not fit the robot, has gaps, is too short, or has no motion or no torque.
        """
        record = rigid_record(log, regressor.robot, label, settings.hold)
        cutoff = settings.cutoff_at(1 / record.sample_time)
        motion = estimate_motion(record.position, record.sample_time, cutoff)
        _check_signals(record, motion, regressor.robot.joint_names, label)
        torque = decimate(record.torque, decimation(record.sample_time, cutoff))
        return cls(record, motion, regressor, base.leading, cutoff, torque, [])

    @property
    def factor(self) -> int:
        """Of how many samples one is kept."""
        return decimation(self.record.sample_time, self.cutoff)

    @property
    def rate(self) -> float:
        """Rate after decimation [Hz]."""
        return 1 / (self.record.sample_time * self.factor)

    def blocks(self, progress: Callable[[float], None] | None = None) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Give H, shape (rows, M, r), and the torques beside it, shape (rows, M), a stretch at a time.

        Args:
            progress: Called with the share of the log that was given.
        """
        first = 0
        for H in self.kept or self._evaluated():
            torque = self.torque[first : first + len(H)]
            first += len(H)
            yield H, torque
            if progress is not None:
                progress(first / len(self.torque))

    def triangular(
        self, others: FloatArray | None = None, progress: Callable[[float], None] | None = None
    ) -> FloatArray:
        """Reduce the rows of every motor to the triangular factor R of [H, tau] = Q R.

        All inner products of the rows, and with them the least squares, are those of the few rows of R.

        Args:
            others: Further torques, shape (n, M), which get a column of their own behind tau.
            progress: Called with the share of the log that was reduced.

        Returns:
            Shape (k, M, k) with k = r + 1, or r + 2 where further torques are given.
        """
        n, motors = self.torque.shape
        k = len(self.leading) + (1 if others is None else 2)
        keep = 8 * n * motors * len(self.leading) <= _KEPT_BYTES and not self.kept
        R: FloatArray = np.zeros((motors, k, k))
        fresh, first = [], 0
        for H, torque in self.blocks(progress):
            right = [torque] if others is None else [torque, others[first : first + len(H)]]
            first += len(H)
            rows = np.concatenate([H, np.stack(right, axis=2)], axis=2)
            below = np.concatenate([R, rows.transpose(1, 0, 2)], axis=1)
            R = np.asarray(np.linalg.qr(below, mode="r"))
            if keep:
                fresh.append(H)
        self.kept.extend(fresh)
        return R.transpose(1, 0, 2)

    def residual(self, values: FloatArray, progress: Callable[[float], None] | None = None) -> FloatArray:
        """Give the torque [Nm or N] that values of the base parameters leave unexplained, shape (n, M)."""
        return np.concatenate([torque - H @ values for H, torque in self.blocks(progress)])

    def _evaluated(self) -> Iterator[FloatArray]:
        motion, factor, n = self.motion, self.factor, len(self.record.position)
        half = edge(factor)
        for start in range(0, n - 2 * half, _CHUNK_ROWS * factor):
            cut = slice(start, min(start + (_CHUNK_ROWS - 1) * factor + 2 * half + 1, n))
            signals = motion.position[cut], motion.velocity[cut], motion.acceleration[cut]
            yield decimate(self.regressor.matrix(*signals, self.leading), factor)


def _check_signals(record: RigidRecord, motion: MotionEstimate, joints: tuple[str, ...], label: str) -> None:
    """Refuse a log without motion or without torque."""
    names = ", ".join(joints)
    if not np.any(motion.moving):
        raise InputError(
            f"{label}: no motion: the position of {names} does not change beyond its noise; give a log in which the "
            "motors move"
        )
    if not np.any(record.torque):
        raise InputError(f"{label}: the torque of {names} is zero throughout; give a log with torques")
