"""Thresholds for a rate of false alarms: from noise alone, and from a log of accepted operation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.monitor.design import autocovariances, floor_ratios
from flexros.monitor.sample_stream import WINDOW
from flexros.monitor.tail_probability import threshold, weights_of_mean_square

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.monitor.calibration import Calibration
    from flexros.monitor.design_book import DesignBook
    from flexros.monitor.pose_model import LinearPose

LENGTHS = (1, 10, 100)
"""Windows over which mean squares are evaluated (chosen): 0.1, 1 and 10 s."""
FALSE_ALARMS = 1e-3
"""Default rate of false alarms of the whole monitor [1/h]: one in 1000 h."""
WARNINGS = 100.0
"""False warnings for each false alarm [1] (chosen)."""
LAGS = 4096
"""Lags of the autocovariances (chosen)."""
MOST_LIKELY = 0.01
"""Largest probability of a false alarm of one mean square, for any rate [1] (chosen)."""
HOUR = 3600.0
"""Seconds of an hour."""


@dataclass(frozen=True, eq=False)
class Thresholds:
    """Mean squares over those of noise that raise a warning and an alarm.

    Attributes:
        warning: Of innovations of all motors, then of their disturbance torques, for each length, shape (3, 2 M).
        alarm: The same for alarms, shape (3, 2 M).
    """

    warning: FloatArray
    alarm: FloatArray


def thresholds(
    book: DesignBook,
    samples: int,
    *,
    false_alarms: float = FALSE_ALARMS,
    calibration: Calibration | None = None,
) -> Thresholds:
    """Compute the thresholds.

    All signals and lengths have the same share of the rate, so that the whole monitor keeps it.

    Args:
        book: Designs for the poses of the robot.
        samples: Samples of a window.
        false_alarms: Rate of false alarms of the whole monitor [1/h].
        calibration: Accepted deviations of the robot; None for an exact model.

    Returns:
        The larger thresholds of noise and calibration.
    """
    found = [_by_noise(book, samples, rate) for rate in (WARNINGS * false_alarms, false_alarms)]
    if calibration is not None:
        rates = (WARNINGS * false_alarms, false_alarms)
        found = [
            np.maximum(level, calibration.levels(chances_of(level.shape[1], rate))) for level, rate in zip(found, rates)
        ]
    return Thresholds(*found)


def chances_of(signals: int, rate: float) -> FloatArray:
    """Return the allowed probability of a false alarm of one mean square of each length, shape (3,).

    Args:
        signals: Number of signals.
        rate: Rate of false alarms of all of them together [1/h].
    """
    return np.array([min(rate / (signals * len(LENGTHS)) * length * WINDOW / HOUR, MOST_LIKELY) for length in LENGTHS])


def _by_noise(book: DesignBook, samples: int, rate: float) -> FloatArray:
    """Return the thresholds of noise, the largest of all loads of the gears."""
    found = [_in_situation(book, pose, samples, rate) for pose in book.situations()]
    return np.asarray(np.max(found, axis=0))


def _in_situation(book: DesignBook, pose: LinearPose, samples: int, rate: float) -> FloatArray:
    home = book.at(book.home).design
    covariance, floors = autocovariances(home, pose, book.noise, LAGS), floor_ratios(home, pose, book.noise)
    M = len(book.noise)
    chances = chances_of(2 * M, rate)
    found = np.empty((len(LENGTHS), 2 * M))
    for row, (length, chance) in enumerate(zip(LENGTHS, chances)):
        for signal, column in enumerate(covariance.T):
            every = 1 if signal < M else book.block
            weights, times = weights_of_mean_square(column[::every], samples // every * length)
            found[row, signal] = threshold(weights, times, float(chance))
    return np.asarray(found * floors)
