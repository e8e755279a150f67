"""The decimated regression of one log, evaluated block by block so that memory is bounded."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.rigid.body_torque import body_torque
from flexros.identify.rigid.motion_estimate import (
    MotionEstimate,
    decimate,
    decimation,
    edge,
    estimate_motion,
    untouched_rows,
)
from flexros.identify.rigid.record import torque_as_it_acts
from flexros.record.missing_samples import bridged_motion, long_holes
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.identify.rigid.regressor import RigidRegressor
    from flexros.record.record import Record

_CHUNK_ROWS = 200
"""Decimated rows of a block (chosen)."""

_KEPT_BYTES = 1_000_000_000
"""Largest regressor that is kept [bytes]; a larger one is evaluated again when needed (chosen: no more
than reading such a log takes)."""


@dataclass(frozen=True, eq=False)
class RegressionRows:
    """Regression tau = H pi_b of one log after low-pass and decimation.

    Attributes:
        record: Record of the log.
        motion: Its motion by zero-phase filtering.
        regressor: The regressor.
        leading: Columns of the regressor that count, one per base parameter, length r.
        cutoff: Corner of the low-pass for the positions [Hz].
        counts: Decimated rows that no long hole of the record touches, shape (n_decimated,).
        torque: Torques of the rows that count [Nm or N], shape (n, M); zero, as their regressor, of motors whose motion
            is prescribed, so that these say nothing.
        kept: Blocks of the regressor that were evaluated already; empty when it is too large to be kept.
    """

    record: Record
    motion: MotionEstimate
    regressor: RigidRegressor
    leading: tuple[int, ...]
    cutoff: float
    counts: BoolArray
    torque: FloatArray
    kept: list[FloatArray]

    @classmethod
    def of_record(
        cls, record: Record, torque: FloatArray, cutoff: float, regressor: RigidRegressor, leading: tuple[int, ...]
    ) -> RegressionRows:
        """Filter a record.

        Args:
            record: The record.
            torque: Torques at the instants of its positions [Nm or N], shape (n, M).
            cutoff: Corner of the low-pass for the positions [Hz].
            regressor: The regressor.
            leading: Columns of the regressor that count.

        Raises:
            InputError: The record is too short, or the corner too high for its rate.
        """
        motion = estimate_motion(bridged_motion(record.position, record.valid), record.sample_time, cutoff)
        factor = decimation(record.sample_time, cutoff)
        counts = untouched_rows(long_holes(record.valid), factor)
        torques = decimate(torque, factor)[counts]
        torques[:, list(record.prescribed)] = 0.0
        return cls(record, motion, regressor, leading, cutoff, counts, torques, [])

    def torque_as_it_acts(self) -> FloatArray | None:
        """Return the torques with delay and hold of the command [Nm or N], shape (n, M); None for measured ones."""
        if self.record.measured_torque:
            return None
        acting, _ = torque_as_it_acts(self.record, self.regressor.robot.delay)
        acting[:, list(self.record.prescribed)] = 0.0
        return self.decimated(acting)

    def decimated(self, values: FloatArray) -> FloatArray:
        """Return further values of the samples, filtered like the torques, in the rows that count.

        Args:
            values: One per sample, shape (n, ...).
        """
        return decimate(values, self.factor)[self.counts]

    def torque_of_turned(self, offsets: FloatArray, numbers: Mapping[str, float] = MappingProxyType({})) -> FloatArray:
        """Return by how much more torque the bodies need at other positions and under gravity of another direction.

        Args:
            offsets: Offsets of the encoders of all motors, by which positions are less [rad or m], shape (M,).
            numbers: Values of the robot in place of its own, by name of the parameter [SI]; only the torque that is
                needed more is that of another gravity.

        Returns:
            Torques in the rows that count [Nm or N], shape (n, M).
        """
        bodies, motion = body_torque(self.regressor.robot), self.motion
        as_stated = {name: value for name, value in numbers.items() if name not in GRAVITY}
        here, there = (
            bodies(position, motion.velocity, motion.acceleration, values)
            for position, values in ((motion.position, as_stated), (motion.position - offsets, numbers))
        )
        there[:, list(self.record.prescribed)] = here[:, list(self.record.prescribed)]
        return self.decimated(there - here)

    @property
    def factor(self) -> int:
        """Decimation factor."""
        return decimation(self.record.sample_time, self.cutoff)

    @property
    def rate(self) -> float:
        """Rate after decimation [Hz]."""
        return 1 / (self.record.sample_time * self.factor)

    def blocks(self, progress: Callable[[float], None] | None = None) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield H, shape (rows, M, r), with its torques, shape (rows, M), block by block.

        Args:
            progress: Called with the share of the log that is done.
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

        R has the inner products of all rows and therefore the same least-squares solution.

        Args:
            others: Further torques, shape (n, M), which get a column of their own after tau.
            progress: Called with the share of the log that was reduced.

        Returns:
            Shape (k, M, k) with k = r + 1, or r + 2 with further torques.
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
        """Return the torque residual of values of the base parameters [Nm or N], shape (n, M)."""
        return np.concatenate([torque - H @ values for H, torque in self.blocks(progress)])

    def _evaluated(self) -> Iterator[FloatArray]:
        motion, factor, n = self.motion, self.factor, len(self.record.position)
        half, first = edge(factor), 0
        for start in range(0, n - 2 * half, _CHUNK_ROWS * factor):
            cut = slice(start, min(start + (_CHUNK_ROWS - 1) * factor + 2 * half + 1, n))
            signals = motion.position[cut], motion.velocity[cut], motion.acceleration[cut]
            H = decimate(self.regressor.matrix(*signals, self.leading), factor)
            H[:, list(self.record.prescribed)] = 0.0
            yield H[self.counts[first : first + len(H)]]
            first += len(H)
