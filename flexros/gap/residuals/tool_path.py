"""Tool path interpolated between samples: positions, orientations and their rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


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
        axes = np.broadcast_to(np.eye(3), (len(position), 3, 3)) if orientation is None else _matrices(orientation)
        self._values = np.hstack([position, np.reshape(axes, (len(position), 9))])
        self._rates = np.gradient(self._values, sample_time, axis=0)

    def at(self, time: FloatArray) -> PathPoints:
        """Interpolate between samples, cubically (Hermite).

        Args:
            time: Times within the path [s], shape (m,).
        """
        T = self._time[1]
        k = np.clip((time / T).astype(np.int64), 0, len(self._time) - 2)
        s = (time / T - k)[:, None]
        a, b, da, db = self._values[k], self._values[k + 1], self._rates[k] * T, self._rates[k + 1] * T
        values = a * (1 + 2 * s) * (1 - s) ** 2 + da * s * (1 - s) ** 2 + b * s**2 * (3 - 2 * s) + db * s**2 * (s - 1)
        rates = self._rates[k] * (1 - s) + self._rates[k + 1] * s
        m = len(time)
        return PathPoints(values[:, :3], rates[:, :3], values[:, 3:].reshape(m, 3, 3), rates[:, 3:].reshape(m, 3, 3))


def _matrices(quaternion: FloatArray) -> FloatArray:
    """Rotation matrices of quaternions x, y, z, w, shape (n, 3, 3)."""
    from scipy.spatial.transform import Rotation  # here, because it loads slowly

    return np.asarray(Rotation.from_quat(quaternion).as_matrix())
