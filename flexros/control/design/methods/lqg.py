"""LQG with integral action: state feedback and Kalman filter of the plant with delay and disturbance torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.linalg import LinAlgError, solve_discrete_are

from flexros.control.design.estimator import disturbance_plant, estimator_controller
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class Lqg(AbstractDesignMethod):
    """Linear-quadratic regulator and Kalman filter, both steady, in discrete time.

    The delay is a state. A disturbance torque at each motor is estimated as random walk and cancelled, which is the
    integral action; disturbances at motor and tool cannot be told apart from the motor position, so one is modelled as
    random walk, the other as white (Kwakernaak and Sivan 1972, sections 5.3 and 6.5).

    The regulator minimises the sum of z^2 + (rate_time z')^2 + (torque_weight u)^2, with the tool position z [mm]; the
    filter knows white torques at motor and tool, the walk of the disturbance, and white encoder noise.
    """

    method: ClassVar[str] = "lqg"
    tunable: ClassVar[tuple[str, ...]] = (
        "torque_weight",
        "rate_time",
        "motor_weight",
        "motor_torque",
        "tool_torque",
        "walk",
        "encoder_noise",
        "stiffness_share",
    )

    torque_weight: float = Field(default=0.1, gt=0.0, description="weight of the torque [mm/Nm]")
    rate_time: float = Field(default=0.15, ge=0.0, description="weight of the speed of the tool [s]")
    motor_weight: float = Field(default=15.0, ge=0.0, description="weight of the motor position [mm/rad]")
    motor_torque: float = Field(default=1.2, ge=0.0, description="white torque at the motors, rms [Nm or N]")
    tool_torque: float = Field(default=0.57, ge=0.0, description="white force or torque at the tool, rms [N or Nm]")
    walk: float = Field(default=3.6e-3, gt=0.0, description="step of the disturbance torque in a sample, rms [Nm or N]")
    encoder_noise: float = Field(default=7e-4, gt=0.0, description="white noise of the encoders, rms [rad or m]")
    stiffness_share: float = Field(
        default=0.5, ge=0.0, le=1.0, description="design model between softest (0) and stiffest (1) spring segment [1]"
    )

    def design(self, problem: DesignProblem) -> Design:
        """Design regulator and filter; see `AbstractDesignMethod.design`."""
        plant = problem.sampled_at(self.stiffness_share)
        A, B, C = disturbance_plant(plant)
        n, motors = plant.B.shape[1:]
        T = problem.sample_time
        tool = 1e3 * plant.F[0]
        rate = tool @ (plant.A[0] - np.eye(n)) / T
        cost = tool.T @ tool + self.rate_time**2 * rate.T @ rate
        cost += self.motor_weight**2 * plant.C[0].T @ plant.C[0]
        wrench = plant.G[0][:, motors:]
        noise = np.zeros((n + motors, n + motors))
        noise[:n, :n] = self.motor_torque**2 * plant.G[0][:, :motors] @ plant.G[0][:, :motors].T
        noise[:n, :n] += self.tool_torque**2 * wrench @ wrench.T
        noise[n:, n:] = self.walk**2 * np.eye(motors)
        try:
            feedback = _regulator(plant.A[0], plant.B[0], cost, self.torque_weight**2 * np.eye(motors))
            gain = _filter(A, C, noise, self.encoder_noise**2 * np.eye(motors))
        except (LinAlgError, ValueError) as error:
            raise InputError(f"lqg: the Riccati equation has no solution ({error}); change the weights") from error
        whole = np.hstack([feedback, np.eye(motors)])
        system = estimator_controller(A, B, C, whole, gain)
        return Design(system, T, B, {})


def _regulator(A: FloatArray, B: FloatArray, Q: FloatArray, R: FloatArray) -> FloatArray:
    """Return K of u = -K x."""
    P = solve_discrete_are(A, B, Q, R)
    return np.asarray(np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A))


def _filter(A: FloatArray, C: FloatArray, W: FloatArray, V: FloatArray) -> FloatArray:
    """Return M of the update x + M (y - C x) with the present measurement."""
    P = solve_discrete_are(A.T, C.T, W, V)
    return np.asarray(np.linalg.solve(C @ P @ C.T + V, C @ P).T)
