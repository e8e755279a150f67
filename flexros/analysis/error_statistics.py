"""Statistics of an error series: maximum, rms, percentile, and location of the maximum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of an error series; sizes have the unit of the series.

    Attributes:
        maximum: Largest absolute value.
        rms: Root of the mean square.
        percentile_95: Absolute value that 95 % of the samples stay below or at.
        time_of_maximum: Time of the largest absolute value [s].
        position_of_maximum: Distance along the commanded path of the largest absolute value [m]; None without a path.
        count: Number of samples.
    """

    maximum: float
    rms: float
    percentile_95: float
    time_of_maximum: float
    position_of_maximum: float | None
    count: int

    def as_dict(self) -> dict[str, float | int | None]:
        """Return the figures as plain numbers, keyed by name."""
        return {
            "max": self.maximum,
            "rms": self.rms,
            "p95": self.percentile_95,
            "time_of_max_s": self.time_of_maximum,
            "position_of_max_m": self.position_of_maximum,
            "samples": self.count,
        }


def error_statistics(error: FloatArray, time: FloatArray, position: FloatArray | None = None) -> ErrorStatistics:
    """Compute the statistics of an error series.

    Args:
        error: Error, signed or not, any unit, shape (n,), n >= 1, finite.
        time: Time of each sample [s], shape (n,).
        position: Distance along the commanded path of each sample [m], shape (n,); None where there is no path.

    Returns:
        The statistics of the absolute error.
    """
    size = np.abs(error)
    worst = int(np.argmax(size))
    return ErrorStatistics(
        maximum=float(size[worst]),
        rms=float(np.sqrt(np.mean(size**2))),
        percentile_95=float(np.percentile(size, 95.0)),
        time_of_maximum=float(time[worst]),
        position_of_maximum=None if position is None else float(position[worst]),
        count=len(size),
    )
