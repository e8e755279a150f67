"""Torque spectrum that a speed reference gives in closed loop, and the error of the measured acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.experiment.closed_loop_response import ControllerResponse


@dataclass(frozen=True, eq=False)
class ExperimentConditions:
    """Excitation and noise that all positions share: one block of n orthogonal multisine experiments, one per motor.

    Attributes:
        frequency: Frequencies that count [Hz], shape (F,).
        amplitude: Amplitude of the speed reference at each frequency [rad/s or m/s], shape (F, M).
        encoder_variance: Variance of the amplitude that encoder noise makes, averaged over the recorded periods: four
            times that of a sample over the number of recorded samples [rad^2 or m^2], shape (M,).
        share: Number of excited lines that each frequency represents.
        distortion: Level of nonlinear distortions at the output relative to its own, rms [1].
    """

    frequency: FloatArray
    amplitude: FloatArray
    encoder_variance: FloatArray
    share: float = 1.0
    distortion: float = 0.0


def input_spectrum(
    response: ComplexArray,
    conditions: ExperimentConditions,
    controller: ControllerResponse,
) -> ComplexArray:
    """Compute the torques of a block of orthogonal multisines in closed loop: U = (I - C_y G)^-1 C_r R.

    The position reference is the integral of the speed reference.

    Args:
        response: FRF from torque command to motor acceleration, shape (..., F, M, M).
        conditions: The excitation.
        controller: Frequency responses of the controller at the same frequencies.

    Returns:
        Torque spectra of the M experiments of a block as columns [Nm or N], shape (..., F, M, M).
    """
    motors = response.shape[-1]
    rate = 2j * np.pi * conditions.frequency[:, None, None]
    position = response / rate**2
    closed = controller.torque(position)
    turns = np.exp(2j * np.pi / motors * np.outer(np.arange(motors), np.arange(motors)))
    excitation = conditions.amplitude[:, :, None] * turns
    return np.asarray((closed[..., :motors] / rate + closed[..., motors:]) @ excitation)


def output_error(response: ComplexArray, spectrum: ComplexArray, conditions: ExperimentConditions) -> FloatArray:
    """Predict the variance of E = Y - G U for one experiment: encoder noise, and distortions relative to the output.

    In closed loop the noise reaches the torque as well, but Y - G U is the noise of the encoder alone.

    Args:
        response: FRF from torque command to motor acceleration, shape (..., F, M, M).
        spectrum: U, shape (..., F, M, n_e).
        conditions: Noise and distortion.

    Returns:
        Variance of the acceleration error at each motor, shape (..., F, M).
    """
    noise = (2 * np.pi * conditions.frequency[:, None]) ** 4 * conditions.encoder_variance
    level = np.mean(np.abs(response @ spectrum) ** 2, axis=-1)
    result: FloatArray = noise + conditions.distortion**2 * level
    return result
