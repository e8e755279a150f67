"""What acts at one frequency all the time, and how it is taken out of prediction errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import dct, idct
from scipy.optimize import minimize_scalar

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class Line:
    """Motion at one frequency, whose amplitude and phase change slowly, as the pose changes the response to it.

    Attributes:
        frequency: The frequency [Hz].
        width: Highest frequency of these changes [Hz].
    """

    frequency: float
    width: float

    def number(self, n: int, sample_time: float) -> int:
        """Return how many values of a signal it determines [1].

        Args:
            n: Samples of the signal.
            sample_time: Time between two [s].
        """
        return 2 * self._slow(n, sample_time)

    def projected_out(self, motors: FloatArray, sample_time: float, used: BoolArray) -> None:
        """Take what it may have caused out of prediction errors, in place.

        Args:
            motors: Weighted prediction errors of the motors, shape (M, n, sets).
            sample_time: Time between two samples [s].
            used: Whether a sample counts, shape (M, n); the others stay zero.
        """
        n = motors.shape[1]
        wave = np.exp(2j * np.pi * self.frequency * sample_time * np.arange(n))[None, :, None]
        slow = dct(motors * wave.conj(), axis=1, norm="ortho")
        slow[:, self._slow(n, sample_time) :] = 0.0
        motors -= 2.0 * (idct(slow, axis=1, norm="ortho") * wave).real * used[:, :, None]

    def _slow(self, n: int, sample_time: float) -> int:
        """Return the number of cosines over the log of which the changes consist."""
        return min(int(2 * self.width * n * sample_time) + 1, n)


def line_in(motors: FloatArray, sample_time: float, width: float, share: float, narrow: float) -> Line | None:
    """Find the line that most of some prediction errors are.

    Args:
        motors: Weighted prediction errors, white and of variance one where nothing acts, shape (M, n).
        sample_time: Time between two samples [s].
        width: Highest frequency at which amplitude and phase of the response to a line change [Hz].
        share: Share of what is above the noise that is near the line, and of this in the line itself [1].
        narrow: Distance to each side that counts as the line itself, over the width [1].

    Returns:
        The line; None where what is left is spread over frequencies, or is where the motion itself is.
    """
    M, n = motors.shape
    power = np.sum(np.abs(np.fft.rfft(motors, axis=1)) ** 2, axis=0) * 2.0 / n
    frequencies = np.fft.rfftfreq(n, sample_time)
    excess = np.maximum(power - 2.0 * M, 0.0)
    peak = frequencies[int(np.argmax(excess))]
    itself, near = (np.abs(frequencies - peak) <= distance for distance in (narrow * width, width))
    around = float(np.sum(excess[near]))
    if peak < 2 * width or around < share * np.sum(excess) or np.sum(excess[itself]) < share * around:
        return None
    times, spacing = sample_time * np.arange(n), 1.0 / (n * sample_time)

    def missed(frequency: float) -> float:
        return -float(np.sum(np.abs(motors @ np.exp(-2j * np.pi * frequency * times)) ** 2))

    found = minimize_scalar(missed, bounds=(peak - spacing, peak + spacing), method="bounded")
    return Line(float(found.x), width)
