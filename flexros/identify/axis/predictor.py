"""One-step predictor of an axis: model and observer of constant gain, prediction errors and their sensitivities."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.identify.axis.recursion import Recursion
from flexros.prediction.observer import kalman_gain

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.axis.record import AxisRecord
    from flexros.identify.axis.structure import AxisStructure


class Predictor:
    """Predicts each sample from the commands and outputs before it (L. Ljung, 1999, System Identification, ch. 5).

    With F the motion over a sample by Runge-Kutta steps, C the output and K the gain:

        e_k = y_k - C x_k,    x_(k+1) = F(x_k, u_k, theta) + K e_k.

    The axis has a rigid motion that no model predicts for long; the gain ties it to the measurement. It is that of the
    stationary Kalman filter for white torques on all masses and white noise of the output, at a small deflection and a
    sliding speed, and is held while theta is sought.

    Args:
        structure: What the model is made of.
        record: Record whose timing the predictor has: sample time and delay.
        smoothing: Speed over which friction changes its sign [rad/s or m/s].
        substeps: Runge-Kutta steps in each part of a sample.
    """

    def __init__(self, structure: AxisStructure, record: AxisRecord, smoothing: float, substeps: int) -> None:
        self.structure, self.smoothing, self.substeps = structure, smoothing, substeps
        self._sample_time, self._durations = record.sample_time, record.durations
        n, P = structure.n_states, len(structure.names)
        self._x, self._theta, self._K = ca.SX.sym("x", n), ca.SX.sym("theta", P), ca.SX.sym("K", n)
        self._input = ca.SX.sym("i", len(self._durations) + 1)

    def gain(self, theta: FloatArray, noise_ratio: float, speed: float) -> FloatArray:
        """Compute the gain of the stationary Kalman filter.

        Args:
            theta: Parameters, shape (P,).
            noise_ratio: Rms of the torque on each mass over rms of the output's noise [Nm/rad or alike].
            speed: Sliding speed at which the friction is linearised [rad/s or m/s].

        Returns:
            Gain K, shape (n_states,).
        """
        A, B = self._linear(theta, speed)
        C = np.zeros((1, len(A)))
        C[0, self.structure.output_index] = 1.0
        # a torque of 1 and a noise of 1 / ratio, over the largest entry, keep the Riccati equation well scaled
        Q, R = B @ B.T, np.array([[noise_ratio**-2]])
        scale = float(np.max(np.abs(Q)))
        gain: FloatArray = (A @ kalman_gain(A, C, Q / scale, R / scale)).ravel()
        return gain

    def memory(self, theta: FloatArray, gain: FloatArray, speed: float) -> int:
        """Return the number of samples after which an initial error has decayed to a thousandth."""
        A, _ = self._linear(theta, speed)
        A[:, self.structure.output_index] -= gain
        radius = float(np.max(np.abs(np.linalg.eigvals(A))))
        return int(np.ceil(np.log(1e-3) / np.log(min(radius, 1 - 1e-9))))

    def errors(self, record: AxisRecord, theta: FloatArray, gain: FloatArray) -> FloatArray:
        """Compute the prediction errors e, zero in samples that were not measured.

        Args:
            record: Commands and outputs.
            theta: Parameters, shape (P,).
            gain: Gain, shape (n_states,).

        Returns:
            Errors [rad or m, or per second], shape (n,).
        """
        outputs = self._plain.run(self._start(record), record.inputs(), np.concatenate([theta, gain]))
        return record.of_measured(record.output - outputs[:, self.structure.output_index])

    def states(self, record: AxisRecord, theta: FloatArray, gain: FloatArray) -> FloatArray:
        """Compute the predicted states; with a gain of zero, the simulated ones. Shape (n, n_states)."""
        return self._plain.run(self._start(record), record.inputs(), np.concatenate([theta, gain]))

    def sensitivities(self, record: AxisRecord, theta: FloatArray, gain: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Compute the prediction errors and their derivatives, zero in samples that were not measured.

        Args:
            record: Commands and outputs.
            theta: Parameters, shape (P,).
            gain: Gain, shape (n_states,).

        Returns:
            Errors, shape (n,), and d e / d theta, shape (n, P).
        """
        n, P = self.structure.n_states, len(theta)
        start = np.concatenate([self._start(record), np.zeros(n * P)])
        outputs = self._with_sensitivities.run(start, record.inputs(), np.concatenate([theta, gain]))
        return record.of_measured(record.output - outputs[:, 0]), record.of_measured(-outputs[:, 1:])

    def _start(self, record: AxisRecord) -> FloatArray:
        """Start at rest on the first measured output, the springs relaxed."""
        start = np.zeros(self.structure.n_states)
        start[self.structure.output_index] = record.output[0]
        return start

    @cached_property
    def _motion(self) -> ca.SX:
        """State one sample later, without correction."""
        f = self.structure.derivative(self.smoothing)
        x = self._x
        for part, duration in enumerate(self._durations):
            u, h = self._input[part], duration / self.substeps
            for _ in range(self.substeps):
                k1 = f(x, u, self._theta)
                k2 = f(x + h / 2 * k1, u, self._theta)
                k3 = f(x + h / 2 * k2, u, self._theta)
                k4 = f(x + h * k3, u, self._theta)
                x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return x

    @cached_property
    def _corrected(self) -> ca.SX:
        return self._motion + self._K * (self._input[-1] - self._x[self.structure.output_index])

    @cached_property
    def _plain(self) -> Recursion:
        parameters = ca.vertcat(self._theta, self._K)
        return Recursion(
            ca.Function("step", [self._x, self._input, parameters], [self._corrected, self._x], {"cse": True})
        )

    @cached_property
    def _with_sensitivities(self) -> Recursion:
        """State [x, dx/dtheta by columns]; output [C x, d C x / dtheta]."""
        n, P = self.structure.n_states, self._theta.numel()
        S = ca.SX.sym("S", n, P)
        columns = [
            ca.jtimes(self._corrected, ca.vertcat(self._x, self._theta), ca.vertcat(S[:, j], ca.SX(np.eye(P)[:, j])))
            for j in range(P)
        ]
        state = ca.vertcat(self._x, ca.vec(S))
        after = ca.vertcat(self._corrected, *columns)
        output = ca.vertcat(self._x[self.structure.output_index], S[self.structure.output_index, :].T)
        parameters = ca.vertcat(self._theta, self._K)
        return Recursion(
            ca.Function("step", [state, self._input, parameters], [ca.densify(after), output], {"cse": True})
        )

    @cached_property
    def _slope(self) -> ca.Function:
        return ca.Function(
            "slope", [self._x, self._input, self._theta], [ca.densify(ca.jacobian(self._motion, self._x))]
        )

    def _linear(self, theta: FloatArray, speed: float) -> tuple[FloatArray, FloatArray]:
        """Return dF/dx while sliding, and the effect of a torque on each mass over a sample."""
        structure = self.structure
        x = np.zeros(structure.n_states)
        x[structure.speed_index :] = speed
        A = self._slope(x, np.zeros(self._input.numel()), theta).full()
        B = np.zeros((structure.n_states, structure.masses))
        for mass, name in enumerate(("motor_inertia", "arm_1_inertia", "arm_2_inertia")[: structure.masses]):
            B[structure.speed_index + mass, mass] = self._sample_time / theta[structure.names.index(name)]
        return A, B
