"""Rows of a reference on demand: as planned, or brought to rest on the way; free of ROS."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flexros.feedforward.motion import Reference

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray


class ReferenceRows(Protocol):
    """A reference that may be too long to be made as a whole."""

    def rows(self, samples: range) -> Reference:
        """Give successive samples."""


class PlannedRows:
    """The rows of a reference as they are.

    Args:
        reference: The whole reference.
    """

    def __init__(self, reference: Reference) -> None:
        self.reference = reference

    def rows(self, samples: range) -> Reference:
        """Give successive samples, step 1."""
        rows = slice(samples.start, samples.stop)
        return Reference(*(getattr(self.reference, field.name)[rows] for field in fields(Reference)))


class RowsToRest:
    """The planned way, gone ever more slowly until it stands still, then held.

    From sample `first` on the plan is read at a time of its own, whose rate falls from one to zero along a polynomial
    of fifth degree with two continuous derivatives. The way does not leave the one that was planned, and so keeps the
    position limits that were checked; nor is it faster anywhere. An excitation on it fades out in the same measure.

    With x = (k - first) / n, the planned sample is first + n (x - x^6 + 3 x^5 - 2.5 x^4), which ends n / 2 after first.
    Positions between two planned samples follow the cubic that has their positions and velocities, everything else the
    straight line. The feedforward torque remains that of the place where the way ends.

    Args:
        reference: The whole reference as planned.
        first: First sample that may differ from the plan.
        n_slowing: Samples from there until it stands still, at least 1.
        sample_time: Time between two samples [s].
    """

    def __init__(self, reference: Reference, first: int, n_slowing: int, sample_time: float) -> None:
        self._reference = reference
        self._first = first
        self._n = n_slowing
        self._sample_time = sample_time

    def rows(self, samples: range) -> Reference:
        """Give successive samples, step 1; they may lie beyond the end of the plan."""
        reference, k = self._reference, np.arange(samples.start, samples.stop, dtype=float)
        x = np.clip((k - self._first) / self._n, 0.0, 1.0)
        slowed = self._first + self._n * (x - x**6 + 3.0 * x**5 - 2.5 * x**4)
        rate = np.where(k < self._first, 1.0, 1.0 - x**3 * (6.0 * x**2 - 15.0 * x + 10.0))
        planned = np.minimum(np.where(k < self._first, k, slowed), len(reference) - 1.0)
        i = planned.astype(int)
        j, share = np.minimum(i + 1, len(reference) - 1), (planned - i)[:, None]

        def line(values: FloatArray) -> FloatArray:
            between: FloatArray = values[i] + share * (values[j] - values[i])
            return between

        position, velocity = self._cubic(i, j, share)
        pose = line(reference.tool_pose)
        length = np.linalg.norm(pose[:, 3:], axis=1, keepdims=True)
        pose[:, 3:] /= np.where(share > 0.0, length, 1.0)  # rows as planned remain so to the last bit
        return Reference(
            time=k * self._sample_time,
            motor_position=position,
            motor_velocity=velocity * rate[:, None],
            torque=line(reference.torque),
            output=line(reference.output),
            tool_pose=pose,
        )

    def _cubic(self, i: IntArray, j: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Position and velocity of the cubic at a share s, shape (n, 1), of the way from the rows i to the rows j."""
        p, q = self._reference.motor_position[i], self._reference.motor_position[j]
        v, w = self._reference.motor_velocity[i], self._reference.motor_velocity[j]
        t = self._sample_time
        position = (
            p * (1 + s**2 * (2 * s - 3)) + q * s**2 * (3 - 2 * s) + t * (v * s * (1 - s) ** 2 + w * s**2 * (s - 1))
        )
        velocity = (q - p) / t * 6 * s * (1 - s) + v * (1 - s) * (1 - 3 * s) + w * s * (3 * s - 2)
        return position, velocity
