"""Rows of a reference on demand: as planned, or with a stop along the path."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flexros.feedforward.motion import Reference

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray


class ReferenceRows(Protocol):
    """Reference that may be too long to be computed as a whole."""

    def rows(self, samples: range) -> Reference:
        """Return successive samples."""


class PlannedRows:
    """Rows of a reference as planned.

    Args:
        reference: The whole reference.
    """

    def __init__(self, reference: Reference) -> None:
        self.reference = reference

    def rows(self, samples: range) -> Reference:
        """Return successive samples, step 1."""
        rows = slice(samples.start, samples.stop)
        return Reference(*(getattr(self.reference, field.name)[rows] for field in fields(Reference)))


class RowsToRest:
    """The planned path, traversed ever more slowly until it stops, then held.

    From sample `first` on the plan is traversed in a scaled time, whose rate decreases from one to zero along a
    polynomial of fifth degree with two continuous derivatives. The motion stays on the planned path, so the checked
    position limits hold, and it is nowhere faster. An excitation on it fades out at the same rate.

    With x = (k - first) / n, the planned sample is first + n (x - x^6 + 3 x^5 - 2.5 x^4), which ends n / 2 after first.
    Positions between two planned samples follow the cubic through their positions and velocities; all else is linear.
    The feedforward torque remains that of the final position.

    Args:
        reference: The whole reference as planned.
        first: First sample that may differ from the plan.
        n_slowing: Samples from there to standstill, at least 1.
        sample_time: Time between two samples [s].
    """

    def __init__(self, reference: Reference, first: int, n_slowing: int, sample_time: float) -> None:
        self._reference = reference
        self._first = first
        self._n = n_slowing
        self._sample_time = sample_time

    def rows(self, samples: range) -> Reference:
        """Return successive samples, step 1; they may be beyond the end of the plan."""
        reference, k = self._reference, np.arange(samples.start, samples.stop, dtype=float)
        x = np.clip((k - self._first) / self._n, 0.0, 1.0)
        slowed = self._first + self._n * (x - x**6 + 3.0 * x**5 - 2.5 * x**4)
        rate = np.where(k < self._first, 1.0, 1.0 - x**3 * (6.0 * x**2 - 15.0 * x + 10.0))
        planned = np.minimum(np.where(k < self._first, k, slowed), len(reference) - 1.0)
        i = planned.astype(int)
        j, share = np.minimum(i + 1, len(reference) - 1), (planned - i)[:, None]

        def linear(values: FloatArray) -> FloatArray:
            between: FloatArray = values[i] + share * (values[j] - values[i])
            return between

        position, velocity = self._cubic(i, j, share)
        pose = linear(reference.tool_pose)
        length = np.linalg.norm(pose[:, 3:], axis=1, keepdims=True)
        pose[:, 3:] /= np.where(share > 0.0, length, 1.0)  # planned rows stay bit-equal
        return Reference(
            time=k * self._sample_time,
            motor_position=position,
            motor_velocity=velocity * rate[:, None],
            torque=linear(reference.torque),
            output=linear(reference.output),
            tool_pose=pose,
        )

    def _cubic(self, i: IntArray, j: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return position and velocity of the cubic at the fraction s, shape (n, 1), from the rows i to the rows j."""
        p, q = self._reference.motor_position[i], self._reference.motor_position[j]
        v, w = self._reference.motor_velocity[i], self._reference.motor_velocity[j]
        t = self._sample_time
        position = (
            p * (1 + s**2 * (2 * s - 3)) + q * s**2 * (3 - 2 * s) + t * (v * s * (1 - s) ** 2 + w * s**2 * (s - 1))
        )
        velocity = (q - p) / t * 6 * s * (1 - s) + v * (1 - s) * (1 - 3 * s) + w * s * (3 * s - 2)
        return position, velocity
