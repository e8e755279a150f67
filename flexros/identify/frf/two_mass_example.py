"""The robot example of Moberg (2007), section 4.1.3: a two-mass axis under speed control, swept by a chirp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

SPEED_GAIN = 10.0
"""P gain of the speed controller [Nm s/rad]; its inverse is the -20 dB of figure 4.8."""

CHIRP_AMPLITUDE = 1.0
"""Amplitude of the motor speed reference [rad/s] (chosen)."""

NOISE = 2e-5
"""Measurement noise of the motor position, rms [rad] (chosen; very high in the thesis)."""


@dataclass(frozen=True, eq=False)
class TwoMassAxis:
    """The two-mass axis (4.8) sampled with a zero-order hold.

    Attributes:
        continuous: A and B of the continuous-time model, shapes (4, 4) and (4, 1).
        transition: State to the next sample, shape (4, 4).
        entry: Input matrix of the held torque, shape (4,).
        motor: Output vector of the motor position, shape (4,).
        sample_time: T_s [s].
    """

    continuous: tuple[FloatArray, FloatArray]
    transition: FloatArray
    entry: FloatArray
    motor: FloatArray
    sample_time: float

    @classmethod
    def builtin(cls) -> TwoMassAxis:
        """Return the axis of the built-in robot `two_mass`."""
        from flexros.robot import load_robot
        from flexros.robot.linear.held_input import held_input
        from flexros.robot.linear.linearise import linear_model

        robot = load_robot("two_mass")
        linear = linear_model(robot)
        A, B, C, _ = linear.matrices()
        transition, entry = held_input(A, B, robot.sample_time)
        return cls((A, B), transition, entry[:, 0], C[0], robot.sample_time)

    def speed_response(self, frequency: FloatArray) -> ComplexArray:
        """Return the continuous-time response from torque to motor speed, (4.9) times s.

        Args:
            frequency: Frequencies [Hz], shape (F,).

        Returns:
            Response [rad/s/Nm], shape (F,).
        """
        s: ComplexArray = np.asarray(2j * np.pi * frequency, dtype=complex)
        A, B = self.continuous
        return np.asarray(s * _resolvent(A, B[:, 0], self.motor, s))

    def sampled_speed_response(self, frequency: FloatArray) -> ComplexArray:
        """Return the response of the sampled model with zero-order hold, times j w like the estimates.

        Args:
            frequency: Frequencies [Hz], shape (F,).

        Returns:
            Response [rad/s/Nm], shape (F,).
        """
        s: ComplexArray = np.asarray(2j * np.pi * frequency, dtype=complex)
        z: ComplexArray = np.asarray(np.exp(s * self.sample_time), dtype=complex)
        return np.asarray(s * _resolvent(self.transition, self.entry, self.motor, z))

    def closed_loop(
        self, speed_reference: FloatArray, noise: FloatArray | None = None, torque: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Run the axis under the P speed controller, u_k = K (r_k - (y_k - y_(k-1)) / T_s).

        Args:
            speed_reference: r [rad/s], shape (n,) or (n, number of runs).
            noise: Added to the measured motor position [rad], shape (n, number of runs); default: none.
            torque: Disturbance torque at the motor [Nm], not in the command, shape as for the noise; default: none.

        Returns:
            Torque command u [Nm] and measured motor position y [rad], shape (n, number of runs) each.
        """
        reference = speed_reference if speed_reference.ndim == 2 else speed_reference[:, None]
        runs = max(part.shape[1] for part in (reference, noise, torque) if part is not None)
        state, last = np.zeros((4, runs)), np.zeros(runs)
        u, y = np.empty((len(reference), runs)), np.empty((len(reference), runs))
        for k in range(len(reference)):
            y[k] = self.motor @ state + (0.0 if noise is None else noise[k])
            u[k] = SPEED_GAIN * (reference[k] - (y[k] - last) / self.sample_time)
            last = y[k]
            acting = u[k] if torque is None else u[k] + torque[k]
            state = self.transition @ state + np.outer(self.entry, acting)
        return u, y


def chirp(n: int, sample_time: float, duration: float = 20.0, start: float = 50.0, end: float = 1.0) -> FloatArray:
    """Return the swept sinusoid of the example, from 50 Hz to 1 Hz in 20 s, then zero.

    Args:
        n: Number of samples.
        sample_time: T_s [s].
        duration: Length of the sweep [s].
        start: First frequency [Hz].
        end: Last frequency [Hz].

    Returns:
        Speed reference [rad/s], shape (n,).
    """
    t = np.arange(n) * sample_time
    phase = 2.0 * np.pi * (start * t + 0.5 * (end - start) / duration * t**2)
    return np.asarray(np.where(t <= duration, CHIRP_AMPLITUDE * np.sin(phase), 0.0))


def _resolvent(A: FloatArray, B: FloatArray, C: FloatArray, point: ComplexArray) -> ComplexArray:
    """Return C (p I - A)^-1 B at each point p, shape (F,)."""
    matrices = point[:, None, None] * np.eye(len(A)) - A
    return np.asarray(np.linalg.solve(matrices, np.broadcast_to(B[:, None], (len(point), len(B), 1)))[:, :, 0] @ C)
