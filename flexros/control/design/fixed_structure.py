"""Controllers of fixed structure: PID in series with second-order sections (lead-lag, notches)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.control.design.linear_system import AbstractLinearSystem

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

BIQUAD = ("zero_frequency", "zero_damping", "pole_frequency", "pole_damping")
"""Parameters of a second-order section: natural frequencies [rad/s] and damping ratios [1]."""


@dataclass(frozen=True, eq=False)
class DiscreteSystem(AbstractLinearSystem):
    """A discrete linear system x+ = A x + B e, u = C x + D e."""

    def beside(self, other: DiscreteSystem) -> DiscreteSystem:
        """Return the sum of the outputs of this system and another one, with inputs of their own."""
        n, m = self.order, other.order
        A = np.block([[self.A, np.zeros((n, m))], [np.zeros((m, n)), other.A]])
        B = np.block([[self.B, np.zeros((n, other.B.shape[1]))], [np.zeros((m, self.B.shape[1])), other.B]])
        return DiscreteSystem(A, B, np.hstack([self.C, other.C]), np.hstack([self.D, other.D]))

    def response(self, frequency: FloatArray, sample_time: float) -> ComplexArray:
        """Return the frequency response, complex, shape (F, n_outputs, n_inputs); frequencies [Hz], shape (F,)."""
        return self.transfer(np.exp(2j * np.pi * frequency * sample_time))


def pid_system(kp: float, ki: float, kd: float, derivative_filter: float, sample_time: float) -> DiscreteSystem:
    """Return the PID of the law `pid` away from its limit, with two states.

    Args:
        kp: Proportional gain [Nm/rad].
        ki: Integral gain [Nm/(rad s)].
        kd: Derivative gain [Nms/rad].
        derivative_filter: Time constant of the derivative [s].
        sample_time: Time between two samples [s].
    """
    keep, rate = derivative_filter / (derivative_filter + sample_time), 1.0 / (derivative_filter + sample_time)
    A = np.diag([keep, 1.0])
    B = np.array([[rate * (keep - 1.0)], [sample_time * ki]])
    C, D = np.array([[kd, 1.0]]), np.array([[kp + kd * rate + sample_time * ki]])
    return DiscreteSystem(A, B, C, D)


def biquad_system(
    zero_frequency: float, zero_damping: float, pole_frequency: float, pole_damping: float, sample_time: float
) -> DiscreteSystem:
    """Return a second-order section of unit gain at rest, discretised with the bilinear transform.

    (s^2 / wz^2 + 2 dz s / wz + 1) / (s^2 / wp^2 + 2 dp s / wp + 1): a notch, lead-lag or filter, by its numbers.

    Args:
        zero_frequency: wz [rad/s].
        zero_damping: dz [1]; above 1 the zeros are real.
        pole_frequency: wp [rad/s].
        pole_damping: dp [1].
        sample_time: Time between two samples [s].
    """
    k = 2.0 / sample_time
    above, below = (
        np.array([(k / w) ** 2 + 2 * d * k / w + 1, 2 - 2 * (k / w) ** 2, (k / w) ** 2 - 2 * d * k / w + 1])
        for w, d in ((zero_frequency, zero_damping), (pole_frequency, pole_damping))
    )
    above, below = above / below[0], below / below[0]
    A = np.array([[-below[1], 1.0], [-below[2], 0.0]])
    B = (above[1:] - below[1:] * above[0])[:, None]
    return DiscreteSystem(A, B, np.array([[1.0, 0.0]]), np.array([[above[0]]]))


def lead_lag_system(zero: float, pole: float, sample_time: float) -> DiscreteSystem:
    """Return (s / zero + 1) / (s / pole + 1), discretised with the bilinear transform.

    Args:
        zero: Corner of the zero [rad/s].
        pole: Corner of the pole [rad/s].
        sample_time: Time between two samples [s].
    """
    k = 2.0 / sample_time
    above, below = (np.array([k / corner + 1.0, 1.0 - k / corner]) for corner in (zero, pole))
    above, below = above / below[0], below / below[0]
    B = np.array([[above[1] - below[1] * above[0]]])
    return DiscreteSystem(np.array([[-below[1]]]), B, np.array([[1.0]]), np.array([[above[0]]]))


def lag_system(gain: float, high_pass: float, low_pass: float, sample_time: float) -> DiscreteSystem:
    """Return gain s / (s + high_pass) / (low_pass s + 1), discretised with the bilinear transform.

    Args:
        gain: Gain between the corners.
        high_pass: Corner of the high-pass [rad/s].
        low_pass: Time constant of the low-pass [s].
        sample_time: Time between two samples [s].
    """
    k = 2.0 / sample_time
    pole, scale = (k - high_pass) / (k + high_pass), k / (k + high_pass)
    high = DiscreteSystem(
        np.array([[pole]]), np.array([[scale * (pole - 1.0)]]), np.array([[gain]]), np.array([[gain * scale]])
    )
    pole, scale = (k * low_pass - 1.0) / (k * low_pass + 1.0), 1.0 / (k * low_pass + 1.0)
    low = DiscreteSystem(np.array([[pole]]), np.array([[scale * (1.0 + pole)]]), np.array([[1.0]]), np.array([[scale]]))
    return high.then(low)
