"""Tool path interpolated between samples: positions, orientations and their rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class PathPoints:
    """Predicted path at given times.

    Attributes:
        position: Positions [m], shape (m, 3).
        speed: Speeds [m/s], shape (m, 3).
        axes: Axes of the tool as columns, shape (m, 3, 3).
        axes_speed: Their rates [1/s], shape (m, 3, 3).
    """

    position: FloatArray
    speed: FloatArray
    axes: FloatArray
    axes_speed: FloatArray


class ToolPath:
    """Predicted path of the tool, interpolated.

    Args:
        position: Positions at even times from zero on [m], shape (n, 3).
        orientation: Quaternions x, y, z, w, shape (n, 4); None where it does not turn or its turn is not known.
        sample_time: Time between two samples [s].
    """

    def __init__(self, position: FloatArray, orientation: FloatArray | None, sample_time: float) -> None:
        self._time = sample_time * np.arange(len(position))
        turning = [] if orientation is None else [_matrices(orientation).reshape(len(position), 9)]
        self._values = np.hstack([position, *turning])
        self._rates = np.gradient(self._values, sample_time, axis=0)

    def at(self, time: FloatArray) -> PathPoints:
        """Interpolate between samples, cubically (Hermite).

        Args:
            time: Times within the path [s], shape (m,).
        """
        k, s = self._place(time)
        values, rates = _hermite(self._values, self._rates * self._time[1], k, s), self._rates[k] * (1 - s)
        rates += self._rates[k + 1] * s
        m = len(time)
        if values.shape[1] == 3:
            return PathPoints(values, rates, np.broadcast_to(np.eye(3), (m, 3, 3)), np.zeros((m, 3, 3)))
        return PathPoints(values[:, :3], rates[:, :3], values[:, 3:].reshape(m, 3, 3), rates[:, 3:].reshape(m, 3, 3))

    def position_at(self, time: FloatArray) -> FloatArray:
        """Interpolate the positions alone [m], shape (m, 3); as `at`.

        Args:
            time: Times within the path [s], shape (m,).
        """
        return _hermite(self._values[:, :3], self._rates[:, :3] * self._time[1], *self._place(time))

    def _place(self, time: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the sample before each time, shape (m,), and the share of the step from there, shape (m, 1)."""
        T = self._time[1]
        k = np.clip((time / T).astype(np.int64), 0, len(self._time) - 2)
        return k, (time / T - k)[:, None]


def _hermite(values: FloatArray, changes: FloatArray, k: IntArray, s: FloatArray) -> FloatArray:
    """Interpolate cubically between values with their changes per step, shape (m, columns)."""
    a, b, da, db = values[k], values[k + 1], changes[k], changes[k + 1]
    return np.asarray(
        a * (1 + 2 * s) * (1 - s) ** 2 + da * s * (1 - s) ** 2 + b * s**2 * (3 - 2 * s) + db * s**2 * (s - 1)
    )


def _matrices(quaternion: FloatArray) -> FloatArray:
    """Rotation matrices of quaternions x, y, z, w, shape (n, 3, 3)."""
    from scipy.spatial.transform import Rotation  # here, because it loads slowly

    return np.asarray(Rotation.from_quat(quaternion).as_matrix())
