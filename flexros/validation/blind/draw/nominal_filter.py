"""Size of a deviation: the log-likelihood that a filter of the nominal robot loses without it.

A Kalman filter of constant gain follows the noise-free run of the robot with the deviation. Half the sum of its squared
innovations over their variance is the expected gain in log-likelihood of the true model. Where the model has a
tolerance, what its parameters can explain at their prior does not count.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.linalg import expm, solve_discrete_are

from flexros.compile import compile_function
from flexros.compile.command_delay import split_delay
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

DRIVE, ELSEWHERE = 1.5e-3, 0.5e-3
"""Unknown torque that the filter allows for: what it moves motors and arm per sample, over the noise (chosen)."""
SKIPPED = 0.5
"""Time at the start during which the filter settles [s] (chosen)."""
SMALL = 1e-3
"""Step of difference quotients over the tolerance (chosen)."""


class NominalFilter:
    """Filter of a robot.

    Args:
        robot: The robot without deviations.
        sample_time: Time between two samples [s].
        tolerance: Standard deviations of its parameters, relative, by name; none where the model is exact.
    """

    def __init__(self, robot: Robot, sample_time: float, tolerance: Mapping[str, float] | None = None) -> None:
        self._robot, self._sample_time = robot, sample_time
        self._tolerance = dict(tolerance or {})
        self._gain, self._whitener = filter_gain(robot, sample_time)
        self._model = robot.symbolic(tuple(self._tolerance))
        self._compiled = compile_function(self._step())
        self._slopes: FloatArray | None = None

    def _step(self) -> ca.Function:
        """One sample: innovation, correction, and the way to the next sample by Runge-Kutta steps."""
        robot, model = self._robot, self._model
        n, m = 2 * robot.n_coordinates, robot.n_motors
        x, y = ca.SX.sym("x", n), ca.SX.sym("y", m)
        old, new = ca.SX.sym("old", m), ca.SX.sym("new", m)
        p = ca.SX.sym("p", len(self._tolerance))
        innovation = y - model.encoder(x[: robot.n_coordinates])
        state = x + ca.DM(self._gain) @ innovation
        fraction = split_delay(robot.delay, self._sample_time).fraction * self._sample_time
        for torque, h in ((old, fraction), (new, self._sample_time - fraction)):
            if h > 0.0:
                state = self._runge_kutta(state, torque, p, h)
        return ca.Function("filter", [x, y, old, new, p], [ca.densify(state), innovation], {"cse": True})

    def _runge_kutta(self, x: ca.SX, u: ca.SX, p: ca.SX, h: float) -> ca.SX:
        f, w = self._model.derivative, ca.DM.zeros(6)
        k1 = f(x, u, w, p)
        k2 = f(x + h / 2 * k1, u, w, p)
        k3 = f(x + h / 2 * k2, u, w, p)
        k4 = f(x + h * k3, u, w, p)
        return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def innovations(self, encoder: FloatArray, command: FloatArray, parameters: FloatArray | None = None) -> FloatArray:
        """Run the filter.

        Args:
            encoder: Encoder values [rad or m], shape (n, M).
            command: Commands [Nm or N], shape (n, M).
            parameters: Values of the parameters with a tolerance [SI]; the nominal ones when None.

        Returns:
            Innovations over their standard deviation, decorrelated, after the time of settling, shape (n - n_0, M).
        """
        robot, delay = self._robot, split_delay(self._robot.delay, self._sample_time)
        rest = robot.equilibrium(robot.home, motor_position=encoder[0])
        x, after = rest.copy(), rest.copy()
        y, old, new, e = (np.zeros(robot.n_motors) for _ in range(4))
        p = np.asarray(self._model.parameter_values if parameters is None else parameters, dtype=float)
        step = self._compiled.bind(x, y, old, new, p, after, e)
        lead = np.repeat(command[:1], delay.whole + 1, axis=0)
        late = np.concatenate([lead, command])
        found = np.empty_like(encoder)
        for k in range(len(encoder)):
            y[:], old[:], new[:] = encoder[k], late[k], late[k + 1]
            step()
            x[:], found[k] = after, e
        skip = min(round(SKIPPED / self._sample_time), len(found) // 2)
        return np.asarray(found[skip:] @ self._whitener.T)

    def expected_gain(self, encoder: FloatArray, command: FloatArray) -> float:
        """Compute the expected gain in log-likelihood of the true model, from a noise-free run.

        Args:
            encoder: Encoder values [rad or m], shape (n, M).
            command: Commands [Nm or N], shape (n, M).

        Returns:
            Gain, less what the parameters with a tolerance explain at their prior [nats].
        """
        e = self.innovations(encoder, command).ravel()
        if not np.all(np.isfinite(e)):
            return np.inf
        if not self._tolerance:
            return float(e @ e) / 2
        J = self.tolerance_slopes(encoder, command)
        assert J is not None
        score = J.T @ e
        return float(e @ e - score @ np.linalg.solve(J.T @ J + np.eye(J.shape[1]), score)) / 2

    def tolerance_slopes(self, encoder: FloatArray, command: FloatArray) -> FloatArray | None:
        """Compute the derivatives of the innovations by the parameters with a tolerance, for the first run given.

        Args:
            encoder: Encoder values [rad or m], shape (n, M).
            command: Commands [Nm or N], shape (n, M).

        Returns:
            Derivatives in standard deviations of the parameters, shape (n_innovations, P); None where none has a
            tolerance.
        """
        if self._tolerance and self._slopes is None:
            self._slopes = self._slope_of(encoder, command, self.innovations(encoder, command).ravel())
        return self._slopes

    def price(self, factors: Mapping[str, float]) -> float:
        """Return the largest cost of explaining a change of the robot as a deviation within tolerance.

        Args:
            factors: Factors by which parameters of the robot are off, by name.

        Returns:
            Sum of (ln factor / tolerance)^2 / 2 [nats]; infinite where a parameter has no tolerance.
        """
        if not factors or not factors.keys() <= self._tolerance.keys():
            return float("inf")
        return sum((float(np.log(factor)) / self._tolerance[name]) ** 2 for name, factor in factors.items()) / 2

    def _slope_of(self, encoder: FloatArray, command: FloatArray, e: FloatArray) -> FloatArray:
        """Derivatives of the innovations by the parameters, in standard deviations of these, shape (n, P)."""
        value = self._model.parameter_values
        columns = []
        for place, sd in enumerate(self._tolerance.values()):
            moved = value.copy()
            moved[place] *= 1 + SMALL * sd
            columns.append((self.innovations(encoder, command, moved).ravel() - e) / SMALL)
        return np.stack(columns, axis=1)


def filter_gain(robot: Robot, sample_time: float, noise: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Compute the filter of a robot.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        noise: Standard deviation of each encoder [rad or m], shape (M,); that of the robot when None.

    Returns:
        Gain of the correction, shape (2 n, M), and the matrix that makes innovations white, shape (M, M).
    """
    linear = linear_model(robot)
    A = np.asarray(linear.matrices()[0])
    n, noise = robot.n_coordinates, robot.encoder_noise if noise is None else noise
    A = expm(A * sample_time)
    C = np.hstack([linear.encoder, np.zeros_like(linear.encoder)])
    size = np.full(n, ELSEWHERE * float(np.mean(robot.encoder_noise)))
    size[list(robot.motor_rows)] = DRIVE * robot.encoder_noise
    G = np.vstack([np.eye(n) / 2, np.eye(n) / sample_time])
    Q = G @ np.diag(size**2) @ G.T + 1e-12 * np.diag(np.concatenate([size, size / sample_time]) ** 2)
    P = solve_discrete_are(A.T, C.T, Q, np.diag(noise**2))
    S = C @ P @ C.T + np.diag(noise**2)
    return np.asarray(P @ C.T @ np.linalg.inv(S)), np.linalg.inv(np.linalg.cholesky(S))
