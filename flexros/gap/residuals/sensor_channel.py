"""One channel of a further sensor: which values are compared, and how their errors are weighed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.further_sensors import SensorRecord


def fast_length_covering(length: int) -> int:
    """Return the least length, at least the given one, whose Fourier transform is fast."""
    return int(next_fast_len(length, real=True))


@dataclass(frozen=True, eq=False)
class SensorChannel:
    """One channel of a further sensor and the weight of its errors.

    Attributes:
        sensor: The measurement.
        deflection: Whether the link minus the motor is compared, as a strain gauge measures it, not the link alone.
        measured: The compared values, shape (m,).
        sample: Sample of the log before each value, shape (m,).
        share: Time since that sample over the sample time [1], shape (m,).
        noise: Standard deviation of the sensor's own noise [its unit], with the tolerance of a measured machine.
        readout: Row from the state of the robot to the sensor, shape (2 n,).
        used: Which values are used, shape (m,).
        whitening: Inverse root of the spectrum of the errors without a gap, over the frequencies of the Fourier
            transform of the values, zeros appended to a fast length, shape (f,).
        unknown: Orthonormal basis of the effect of unknown offset, scale and time of the sensor, shape (m, k).
        removed: Share of each that is projected out [1]; 1 for an offset, less where a prior limits it, shape (k,).
        noise_error: Relative standard deviation of the square of the noise, zero where it is declared [1].
    """

    sensor: SensorRecord
    deflection: bool
    measured: FloatArray
    sample: IntArray
    share: FloatArray
    noise: float
    readout: FloatArray
    used: BoolArray
    whitening: FloatArray
    unknown: FloatArray
    removed: FloatArray
    noise_error: float = 0.0

    def predicted(self, outputs: FloatArray, motor: FloatArray, samples: IntArray) -> FloatArray:
        """Interpolate what the model predicts to the times of the values, shape (m, sets).

        Args:
            outputs: Output of the model at some samples, shape (n_p, sets).
            motor: Position of the motor there, shape (n_p, sets).
            samples: These samples, increasing, with all that are needed, shape (n_p,).
        """
        values = outputs - motor if self.deflection else outputs
        row = np.searchsorted(samples, self.sample)
        if not np.any(self.share):
            return np.asarray(values[row])
        after = np.minimum(row + 1, len(samples) - 1)
        return np.asarray(values[row] + self.share[:, None] * (values[after] - values[row]))

    def weighted(self, error: FloatArray) -> FloatArray:
        """Whiten and weigh errors, with what is unknown of the sensor projected out.

        Args:
            error: Measured minus predicted values, shape (m, sets).
        """
        result = self._whitened(error)
        result -= self.unknown @ (self.removed[:, None] * (self.unknown.T @ result))
        return result

    def _whitened(self, error: FloatArray) -> FloatArray:
        length = fast_length_covering(len(error))
        spectrum = rfft(np.where(self.used[:, None], error, 0.0), length, axis=0)
        white = irfft(spectrum * self.whitening[:, None], length, axis=0)[: len(error)]
        return np.asarray(np.where(self.used[:, None], white, 0.0))

    def with_unknown(self, directions: Sequence[FloatArray]) -> SensorChannel:
        """Project out errors of the sensor, each as far as its prior standard deviation allows.

        Args:
            directions: Error of the values by one standard deviation of an unknown, shape (m,) each.
        """
        effects = self._whitened(np.stack(directions, axis=1))
        basis, sizes, _ = np.linalg.svd(effects, full_matrices=False)
        kept = sizes > 0.0
        removed = 1.0 - 1.0 / np.sqrt(1.0 + sizes[kept] ** 2)
        return replace(self, unknown=basis[:, kept], removed=removed)
