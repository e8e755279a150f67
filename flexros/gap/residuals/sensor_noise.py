"""Noise and colour of the errors of further sensors, whose observer is corrected by the motor encoders alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.quantization import lattice_step

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.prediction.observer import ObserverGain

FARTHEST = 4.0
"""Fourth differences, over their standard deviation, beyond which they are impacts and no noise [1] (chosen)."""
WELL_CONDITIONED = 1e10
"""Condition of the eigenvectors of the error dynamics up to which the spectrum is summed over modes [1] (chosen)."""


def white_noise(error: FloatArray, values: FloatArray) -> float:
    """Estimate the white noise of a sensor, from fourth differences, which hardly show motion; at least its rounding.

    The relative standard deviation of its square is `variance_error`.

    Args:
        error: Measured minus predicted values, shape (m,).
        values: Measured values, shape (m,).
    """
    differences = np.abs(np.diff(error, 4)) / np.sqrt(70.0)
    step = lattice_step(values)
    rounding = 0.0 if step is None else step / np.sqrt(12.0)
    if not differences.size:
        return rounding
    usual = differences[differences <= FARTHEST * 1.4826 * float(np.median(differences))]
    return max(float(np.sqrt(np.mean(usual**2))) if usual.size else 0.0, rounding)


def variance_error(n: int) -> float:
    """Return the relative standard deviation of the square of a noise that `white_noise` estimates from n values.

    sqrt(2 c / n), where c = 2.63 is the sum of the squared autocorrelations of fourth differences of white noise.
    """
    return float(np.sqrt(2 * 2.63 / max(n, 1)))


def error_spectrum(
    gain: ObserverGain, readout: FloatArray, deviation: float, step: int, turns: FloatArray
) -> FloatArray:
    """Compute the spectrum of the errors of a sensor without a gap.

    The error is C x + v: v is the white noise of the sensor and x the error of the observed state, which noise of the
    motor encoders and tolerated torques leave, with the covariance P and the transition A of the corrected observer:

        S(w) = var v + 2 Re C (I - A e^-iw)^-1 P C' - C P C'

    Args:
        gain: Gain and error dynamics of the observer.
        readout: Row C from the state to the sensor, shape (2 n,).
        deviation: Standard deviation of v.
        step: Samples of the log between two values of the sensor.
        turns: Frequencies w / (2 pi), in periods per value [1], shape (f,).

    Returns:
        Spectrum, with the mean over all frequencies equal to the variance of the errors, shape (f,).
    """
    kept = np.eye(len(gain.motion)) - gain.gain @ gain.readout
    transition = np.linalg.matrix_power(kept @ gain.motion, step)
    shared, shift = gain.error @ readout, np.exp(-2j * np.pi * turns)
    values, vectors = np.linalg.eig(transition)
    if np.linalg.cond(vectors) < WELL_CONDITIONED:
        weights = (readout @ vectors) * np.linalg.solve(vectors, shared)
        summed = sum(weight / (1 - value * shift) for weight, value in zip(weights, values, strict=True))
    else:
        matrices = np.eye(len(values)) - shift[:, None, None] * transition
        summed = np.linalg.solve(matrices, np.broadcast_to(shared[:, None], (len(turns), len(shared), 1)))[:, :, 0]
        summed = summed @ readout
    of_state = np.maximum(2 * np.real(summed) - float(readout @ shared), 0.0)
    return np.asarray(deviation**2 + of_state)
