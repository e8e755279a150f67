"""Disturbance torques of a model, estimated from its prediction errors.

With the predictor's error x = state minus predicted state, a disturbance torque d at the motors and noise n,

    e_k = C x_k + n_k,   x_k+1 = F (I - K C) x_k + B d_k - F K n_k,

so that E = G D + H N with G = C (zI - F(I - KC))^-1 B and H = I - C (zI - F(I - KC))^-1 F K. With d
modelled as a random walk of power density q / |1 - 1/z|^2, the best estimate from the whole log is that of Wiener
(1949),

    D = S G^H (G S G^H + H R H^H)^-1 E,

which equals that of a Kalman smoother with a disturbance state and is computed by Fourier transform.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.robot.linear.held_input import held_input
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record
    from flexros.robot import Robot

BANDWIDTH = 60.0
"""Frequency [Hz] at which the assumed disturbance torque and noise contribute equally to prediction errors (chosen)."""

SLOWEST = 1.0
"""Frequency [Hz] below which the assumed torques in gears are constant, as they are not observable (chosen)."""
LEAST_NOISE = 0.01
"""Relative noise power that is added because the predictor passes none at zero frequency [1] (chosen)."""
FADE = 0.3
"""Duration of the fade of the prediction errors at both ends of a log [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class _ErrorDynamics:
    """Dynamics from noise and disturbance torques to the prediction errors of a predictor with a fixed gain.

    Attributes:
        transition: F (I - K C), shape (n_x, n_x).
        injection: F K, shape (n_x, M).
        measurement: C, shape (M, n_x).
    """

    transition: FloatArray
    injection: FloatArray
    measurement: FloatArray

    @classmethod
    def of(cls, observer: ObserverGain) -> _ErrorDynamics:
        """Build the error dynamics of a predictor."""
        return cls(observer.transition, observer.motion @ observer.gain, observer.readout)

    def response(self, z: ComplexArray, entry: FloatArray) -> ComplexArray:
        """Evaluate C (zI - F(I - KC))^-1 B.

        Args:
            z: Points on the unit circle, shape (F,).
            entry: Input matrix B, shape (n_x, k).

        Returns:
            Response, shape (F, M, k).
        """
        values, vectors = np.linalg.eig(self.transition)
        left = self.measurement @ vectors
        right = np.linalg.solve(vectors, entry.astype(complex))
        modal = 1 / (z[:, None] - values)
        return np.asarray(np.einsum("ai,fi,ib->fab", left, modal, right, optimize=True))


def disturbance_torque(
    innovations: FloatArray,
    record: Record,
    robot: Robot,
    observer: ObserverGain,
    q_a: FloatArray | None = None,
    bandwidth: float = BANDWIDTH,
    entry: Literal["motor", "gear"] = "motor",
) -> FloatArray:
    """Estimate the disturbance torques at all samples.

    Args:
        innovations: Prediction errors [rad or m], shape (n, M).
        record: The log.
        robot: The model of the predictions; it is linearised at rest.
        observer: Observer gain of the predictions.
        q_a: Arm coordinates of the pose [rad or m], shape (N,); default: home.
        bandwidth: Frequency [Hz] above which the estimate decays to zero.
        entry: "motor" for torques on the motors alone, "gear" for torques between motor and arm. The latter do not
            move the robot as a whole, so their slow part is not observable and its estimate is zero.

    Returns:
        Torques to be added to those of the model [Nm or N], shape (n, M).
    """
    n = len(innovations)
    dynamics = _ErrorDynamics.of(observer)
    frequency: FloatArray = np.asarray(np.fft.rfftfreq(n, record.sample_time), dtype=float)
    # above four times the bandwidth the estimate is zero to a few per cent
    within = np.flatnonzero(frequency <= min(4 * bandwidth, 0.45 / record.sample_time))
    z = np.exp(2j * np.pi * frequency[within] * record.sample_time)
    path = _torque_response(robot, dynamics, record.sample_time, z, q_a, entry)
    noise = _noise(dynamics, observer.noise, z)
    spectrum = np.zeros((len(frequency), innovations.shape[1]), dtype=complex)
    slowest = 2 * np.pi * SLOWEST * record.sample_time if entry == "gear" else 1e-9
    errors = np.fft.rfft(innovations * _faded(n, record.sample_time), axis=0)[within]
    middle = int(np.argmin(np.abs(frequency[within] - bandwidth)))
    spectrum[within] = _wiener(path, noise, np.abs(1 - 1 / z) ** 2 + slowest**2, errors, middle)
    return np.asarray(np.fft.irfft(spectrum, n, axis=0))


def _torque_response(
    robot: Robot,
    dynamics: _ErrorDynamics,
    sample_time: float,
    z: ComplexArray,
    q_a: FloatArray | None,
    entry: Literal["motor", "gear"],
) -> ComplexArray:
    """Return G, shape (F, M, M)."""
    model = linear_model(robot, q_a)
    A, _, _, _ = model.matrices()
    force = model.input.copy()
    for motor in robot.flexible_motors if entry == "gear" else ():
        force[robot.gear_rows[motor], motor] -= 1.0
    B = np.vstack([np.zeros_like(force), np.linalg.solve(model.mass, force)])
    return dynamics.response(z, held_input(A, B, sample_time)[1])


def _noise(dynamics: _ErrorDynamics, sd: FloatArray, z: ComplexArray) -> ComplexArray:
    """Return H R H^H plus `LEAST_NOISE`, shape (F, M, M)."""
    H = np.eye(len(sd)) - dynamics.response(z, dynamics.injection)
    variance = np.maximum(sd, 1e-12) ** 2
    return np.asarray(np.einsum("fij,j,fkj->fik", H, variance, H.conj()) + LEAST_NOISE * np.diag(variance))


def _faded(n: int, sample_time: float) -> FloatArray:
    """Return weights that rise from zero at the beginning of a log and fall to zero at its end, shape (n, 1)."""
    time = (np.arange(n) + 0.5) * sample_time
    ends = np.minimum(time, time[::-1]) / FADE
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(ends, 1.0)))[:, None]


def _wiener(
    path: ComplexArray, noise: ComplexArray, steadiness: FloatArray, error: ComplexArray, middle: int
) -> ComplexArray:
    """Return the spectrum of the estimate.

    Args:
        path: G, shape (F, M, M).
        noise: H R H^H, shape (F, M, M).
        steadiness: Inverse of the assumed power density of the torques, up to a factor, shape (F,).
        error: Spectrum of the prediction errors, shape (F, M).
        middle: Index of the frequency at which torques and noise are assumed to contribute equally to the errors.

    Returns:
        Spectrum, shape (F, M).
    """
    own = np.abs(np.einsum("fii->fi", path[middle : middle + 1])[0]) ** 2
    level = np.einsum("ii->i", noise[middle]).real * steadiness[middle] / own
    S = level / steadiness[:, None]
    adjoint = S[:, :, None] * path.conj().transpose(0, 2, 1)
    inner = np.linalg.solve(path @ adjoint + noise, error[:, :, None])
    return np.asarray((adjoint @ inner)[:, :, 0])
