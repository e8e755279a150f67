"""LQG: state feedback from a stationary Kalman filter, with integral action."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
from pydantic import Field

from flexros.control.limited import AbstractSignalLaw, Gain
from flexros.control.model.sampled_model import SampledModel, kalman_gain, lq_gain, sampled_model
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals
    from flexros.robot import Robot


_STABLE = 1e-7
"""Least distance of the poles of the feedback from the unit circle [1]; nearer ones have no cost."""


@dataclass(frozen=True, eq=False)
class LqgDesign:
    """Matrices of the law; its states are those of the sampled model, then the disturbance torques of the motors.

    Attributes:
        model: The sampled model.
        A: Shape (n + M, n + M).
        B: Shape (n + M, M).
        C: Shape (n_y, n + M).
        K: Feedback of states and disturbances, shape (M, n + M).
        L: Gain of the filter, shape (n + M, n_y).
        covariance: Of the error of the filter after the measurement, shape (n + M, n + M).
    """

    model: SampledModel
    A: FloatArray
    B: FloatArray
    C: FloatArray
    K: FloatArray
    L: FloatArray
    covariance: FloatArray


class Lqg(AbstractSignalLaw):
    """LQG control about the reference (Moberg 2007, section 5.3.2), with the delay of the command as states.

        x = z + L (y - y_r - C z),   u = u_ffw - K x,   z+ = A x + B (u - u_ffw)

    All signals are deviations from the reference. The model is the robot linearised at rest and sampled; torques of
    unknown constant level at the motors (random walks) give integral action, as K cancels them. K minimises the sum of
    squares of tool deviation / tool_accuracy, motor deviation / motor_accuracy and torque / effort, L the error for
    white torques at the motors, white forces at the tool, the drift of the torques and the noise of the sensors.
    Further measurements are compared with the motion of the links (`link_position`) or with their values at rest
    (`joint_torque`, `tool_acceleration`, `tool_turning_rate`), which is for regulation. The filter gets the limited
    torque, so nothing winds up.
    """

    kind: ClassVar[str] = "lqg"
    gain_keys: ClassVar[tuple[str, ...]] = ("loop_gain",)

    measurements: tuple[str, ...] = Field(
        default=("motor_position",), min_length=1, description="measurements that the filter uses [name]"
    )
    tool_accuracy: float = Field(default=1e-3, gt=0.0, description="deviation of the tool that costs one unit [m]")
    motor_accuracy: float | None = Field(
        default=None, gt=0.0, description="deviation of a motor that costs one unit [rad]; default: it costs nothing"
    )
    effort: float = Field(gt=0.0, description="torque of a motor that costs one unit [Nm]")
    torque_noise: float = Field(gt=0.0, description="white torque at every motor, rms over a sample [Nm]")
    force_noise: float = Field(default=0.0, ge=0.0, description="white force along each axis of the tool, rms [N]")
    moment_noise: float = Field(default=0.0, ge=0.0, description="white moment about each axis of the tool, rms [Nm]")
    torque_drift: float = Field(
        default=0.0,
        ge=0.0,
        description="random walk of the torque at every motor, rms [Nm per root s]; 0 for no integral",
    )
    pose: tuple[float, ...] | None = Field(
        default=None, description="arm coordinates of the design [rad or m]; default: home of the robot"
    )
    spring_segment: int = Field(default=0, description="segment of piecewise linear springs for the design [1], from 0")
    loop_gain: Gain = Field(default=1.0, description="factor on the feedback [1], one or one per motor")
    observer_gain: float = Field(default=1.0, ge=0.0, description="factor on the gain of the filter [1]")

    @property
    def follows_link_motion(self) -> bool:
        """Whether the references include the motion of the links: where their encoders are used."""
        return "link_position" in self.measurements

    def check(self, context: LoopContext) -> None:
        """Refuse a robot without the sensors, or without noise of them."""
        sampled_model(context, self.measurements, self.pose, self.spring_segment)

    def design(self, context: LoopContext) -> LqgDesign:
        """Compute the matrices of the law, once per loop."""
        return _design(self, context.robot, context.sample_time)

    def _matrices(self, context: LoopContext) -> LqgDesign:
        model = sampled_model(context, self.measurements, self.pose, self.spring_segment)
        n, m, robot = model.size, context.n_motors, context.robot
        cost = model.F.T @ model.F / self.tool_accuracy**2
        if self.motor_accuracy is not None:
            motors = np.eye(n)[list(robot.motor_rows)]
            cost += motors.T @ motors / self.motor_accuracy**2
        K = self._feedback(model, cost, np.eye(m) / self.effort**2)
        past = K[:, 2 * robot.n_coordinates :].reshape(m, -1, m).sum(axis=1)  # past commands hold the disturbance too
        A = np.block([[model.A, model.G[:, :m]], [np.zeros((m, n)), np.eye(m)]])
        B = np.vstack([model.B, np.zeros((m, m))])
        C = np.hstack([model.C, np.zeros((len(model.C), m))])
        rms = np.array([self.torque_noise] * m + [self.force_noise] * 3 + [self.moment_noise] * 3)
        process = np.zeros((n + m, n + m))
        process[:n, :n] = (model.G * rms**2) @ model.G.T
        process[n:, n:] = self.torque_drift**2 * context.sample_time * np.eye(m)
        known = n + m if self.torque_drift else n
        L, covariance = np.zeros((n + m, len(C))), np.zeros((n + m, n + m))
        L[:known], covariance[:known, :known] = kalman_gain(
            A[:known, :known], C[:, :known], process[:known, :known], model.noise
        )
        return LqgDesign(model, A, B, C, np.hstack([K, np.eye(m) + past]), L, covariance)

    def _feedback(self, model: SampledModel, cost: FloatArray, effort: FloatArray) -> FloatArray:
        try:
            K = lq_gain(model.A, model.B, cost, effort)
            slowest = np.max(np.abs(np.linalg.eigvals(model.A - model.B @ K)))
        except np.linalg.LinAlgError:
            slowest = 1.0
        if slowest > 1.0 - _STABLE:
            raise InputError(
                "controller.tool_accuracy alone leaves a motion of the motors without cost, because the tool does not "
                "move with it in this pose; add controller.motor_accuracy"
            )
        return K

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states: of the sampled model, and one disturbance torque per motor."""
        model = sampled_model(context, self.measurements, self.pose, self.spring_segment)
        return model.size + context.n_motors

    def further_gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the factor on the gain of the filter."""
        del context
        return {"observer_gain": self.observer_gain}

    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample; see `AbstractSignalLaw.control`."""
        design, begin = self.design(signals.context), 0
        deviations = []
        for name in self.measurements:
            measured = signals.measured(name)
            rest = design.model.rest[begin : begin + measured.numel()]
            begin += measured.numel()
            compared = name in ("motor_position", "link_position")
            deviations.append(measured - (signals.reference(name) if compared else rest))
        innovation = casadi.vertcat(*deviations) - casadi.mtimes(sparse(design.C), state)
        corrected = state + gains["observer_gain"] * casadi.mtimes(sparse(design.L), innovation)
        feedforward = signals.reference("feedforward_torque")
        wanted = feedforward - gains["loop_gain"] * casadi.mtimes(sparse(design.K), corrected)
        moved = casadi.mtimes(sparse(design.A), corrected)
        return wanted, lambda command: moved + casadi.mtimes(sparse(design.B), command - feedforward)


@lru_cache(maxsize=8)
def _design(law: Lqg, robot: Robot, sample_time: float) -> LqgDesign:
    return law._matrices(law.context(robot, sample_time))


def sparse(matrix: FloatArray) -> casadi.DM:
    """Return a matrix whose zeros cost nothing in a symbolic product."""
    return casadi.sparsify(casadi.DM(matrix))
