"""Torques that a model lacks, estimated from its prediction errors.

With the predictor's error x = state minus predicted state, a missing torque d at the motors and the noise n,

    e_k = C x_k + n_k,   x_k+1 = F (I - K C) x_k + B d_k - F K n_k,

so that E = G D + H N with G = C (zI - F(I - KC))^-1 B and H = I - C (zI - F(I - KC))^-1 F K. Of d it is assumed that
it wanders, with a power density q / |1 - 1/z|^2. The best estimate from the whole log is then Wiener's (1949)

    D = S G^H (G S G^H + H R H^H)^-1 E,

what a Kalman smoother with a disturbance state would give, computed by Fourier transform.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import expm

from flexros.gap.where.floor import ErrorDynamics, error_dynamics
from flexros.robot.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.gap.gain import ObserverGain
    from flexros.gap.record import GapRecord
    from flexros.robot import Robot

BANDWIDTH = 60.0
"""Frequency [Hz] at which assumed missing torque and noise are equally large in the prediction errors (chosen)."""


def missing_torque(
    innovations: FloatArray,
    record: GapRecord,
    robot: Robot,
    observer: ObserverGain,
    q_a: FloatArray | None = None,
    bandwidth: float = BANDWIDTH,
) -> FloatArray:
    """Estimate the missing torques of all samples.

    Args:
        innovations: Prediction errors [rad or m], shape (n, M).
        record: The log.
        robot: The model that made the predictions, linearised at rest.
        observer: The gain that it was made with.
        q_a: Arm coordinates of the pose [rad or m], shape (N,); default: home.
        bandwidth: Above about this frequency [Hz] nothing is estimated.

    Returns:
        Torques that have to be added at the motors [Nm or N], shape (n, M).
    """
    n = len(innovations)
    dynamics = error_dynamics(observer)
    frequency: FloatArray = np.asarray(np.fft.rfftfreq(n, record.sample_time), dtype=float)
    # behind four times the bandwidth the estimate is zero but for a few per cent
    within = np.flatnonzero(frequency <= min(4 * bandwidth, 0.45 / record.sample_time))
    z = np.exp(2j * np.pi * frequency[within] * record.sample_time)
    path = _torque_response(robot, dynamics, record.sample_time, z, q_a)
    noise = _noise(dynamics, observer.noise, z)
    spectrum = np.zeros((len(frequency), innovations.shape[1]), dtype=complex)
    spectrum[within] = _wiener(path, noise, z, np.fft.rfft(innovations, axis=0)[within], frequency[within], bandwidth)
    return np.asarray(np.fft.irfft(spectrum, n, axis=0))


def _torque_response(
    robot: Robot, dynamics: ErrorDynamics, sample_time: float, z: ComplexArray, q_a: FloatArray | None
) -> ComplexArray:
    """Return G, shape (F, M, M)."""
    A, B, _, _ = linear_model(robot, q_a).matrices()
    n, m = B.shape
    held = np.zeros((n + m, n + m))
    held[:n, :n], held[:n, n:] = A, B
    return dynamics.response(z, expm(held * sample_time)[:n, n:])


def _noise(dynamics: ErrorDynamics, sd: FloatArray, z: ComplexArray) -> ComplexArray:
    """Return H R H^H, shape (F, M, M)."""
    H = np.eye(len(sd)) - dynamics.response(z, dynamics.injection)
    return np.asarray(np.einsum("fij,j,fkj->fik", H, np.maximum(sd, 1e-12) ** 2, H.conj()))


def _wiener(
    path: ComplexArray,
    noise: ComplexArray,
    z: ComplexArray,
    error: ComplexArray,
    frequency: FloatArray,
    bandwidth: float,
) -> ComplexArray:
    """Return the spectrum of the estimate, shape (F, M)."""
    wander = 1 / np.maximum(np.abs(1 - 1 / z) ** 2, 1e-18)
    middle = int(np.argmin(np.abs(frequency - bandwidth)))
    own = np.abs(np.einsum("fii->fi", path)) ** 2
    level = np.einsum("ii->i", noise[middle]).real / (own[middle] * wander[middle])
    S = level * wander[:, None]
    adjoint = S[:, :, None] * path.conj().transpose(0, 2, 1)
    inner = np.linalg.solve(path @ adjoint + noise, error[:, :, None])
    return np.asarray((adjoint @ inner)[:, :, 0])
