"""Torque spectrum that a speed reference gives in closed loop, and the error of the measured acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.base import AbstractControlLaw


@dataclass(frozen=True, eq=False)
class ExperimentConditions:
    """What is the same in all positions: one block of n orthogonal multisine experiments, one per motor.

    Attributes:
        frequency: Frequencies that count [Hz], shape (F,).
        amplitude: Amplitude of the speed reference at each frequency [rad/s or m/s], shape (F, M).
        encoder_variance: Variance of the amplitude that encoder noise makes, averaged over the recorded periods: four
            times that of a sample over the number of recorded samples [rad^2 or m^2], shape (M,).
        share: Number of excited lines that each frequency stands for.
        distortion: Level of nonlinear distortions at the output relative to its own, rms [1].
    """

    frequency: FloatArray
    amplitude: FloatArray
    encoder_variance: FloatArray
    share: float = 1.0
    distortion: float = 0.0


def controller_response(
    law: AbstractControlLaw, n_motors: int, sample_time: float, frequency: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Compute the frequency responses of a control law about rest, without its limits.

    Args:
        law: The control law.
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].
        frequency: Frequencies [Hz], shape (F,).

    Returns:
        From the reference [position, velocity, feedforward torque] to the command, shape (F, M, 3 M), and from the
        measured position to the command, shape (F, M, M).
    """
    function = law.function(n_motors, sample_time)
    c, r, y, g = (ca.SX.sym(name, function.size1_in(name)) for name in ("c", "r", "y", "g"))
    u, after = function(c, r, y, g)
    blocks = [ca.densify(ca.jacobian(out, argument)) for out in (u, after) for argument in (c, r, y)]
    evaluate = ca.Function("slopes", [c, r, y, g], blocks)
    started = law.initial_state(n_motors)
    zero_r, zero_y, gains = np.zeros(3 * n_motors), np.zeros(n_motors), law.gains(n_motors)
    rest = function(started, zero_r, zero_y, gains)[1]  # after one sample at rest, so that laws count as begun
    uc, ur, uy, cc, cr, cy = (np.asarray(value) for value in evaluate(rest, zero_r, zero_y, gains))
    z = np.exp(2j * np.pi * frequency * sample_time)[:, None, None]
    inputs = np.broadcast_to(np.hstack([cr, cy]), (len(z), len(cc), 4 * n_motors))
    inner = np.linalg.solve(z * np.eye(len(cc)) - cc, inputs)
    both = np.asarray(np.hstack([ur, uy]) + uc @ inner, dtype=complex)
    return both[..., : 3 * n_motors], both[..., 3 * n_motors :]


def input_spectrum(
    response: ComplexArray,
    conditions: ExperimentConditions,
    reference_gain: ComplexArray,
    feedback_gain: ComplexArray,
) -> ComplexArray:
    """Compute the torques of a block of orthogonal multisines in closed loop: U = (I - C_y G)^-1 C_r R.

    The position reference is the integral of the speed reference.

    Args:
        response: FRF from torque command to motor acceleration, shape (..., F, M, M).
        conditions: The excitation.
        reference_gain: From the reference to the command, shape (F, M, 3 M).
        feedback_gain: From the measured position to the command, shape (F, M, M).

    Returns:
        Torque spectra of the M experiments of a block as columns [Nm or N], shape (..., F, M, M).
    """
    motors = response.shape[-1]
    rate = 2j * np.pi * conditions.frequency[:, None, None]
    position = response / rate**2
    drive = reference_gain[..., :motors] / rate + reference_gain[..., motors : 2 * motors]
    turns = np.exp(2j * np.pi / motors * np.outer(np.arange(motors), np.arange(motors)))
    excitation = conditions.amplitude[:, :, None] * turns
    return np.asarray(np.linalg.solve(np.eye(motors) - feedback_gain @ position, drive @ excitation))


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
