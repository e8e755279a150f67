"""A robot linearised at rest and sampled, with the measurements of its sensors: the model of linear observers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.errors import InputError
from flexros.robot.symbolic.tool_sensors import tool_acceleration, turning_rate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class SampledModel:
    """x+ = A x + B u + G d, y = C x, z = F x about rest; x = [dq, dv, past commands, newest first].

    Attributes:
        A: Shape (n, n).
        B: From the commands [Nm or N], shape (n, M).
        C: To the measurements, shape (n_y, n).
        G: From the torque at the motors (M) and the wrench at the tool (6), held over a sample, shape (n, M + 6).
        F: To the position of the tool [m], shape (3, n).
        rest: Measurements at rest, shape (n_y,).
        noise: Their noise, rms, shape (n_y,).
        positions: Rows of the motors' positions, then of the links' positions, shape (2, M).
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    G: FloatArray
    F: FloatArray
    rest: FloatArray
    noise: FloatArray
    positions: FloatArray

    @property
    def size(self) -> int:
        """Number of states, n."""
        return len(self.A)


def sampled_model(
    context: LoopContext, measurements: Sequence[str], pose: Sequence[float] | None = None, segment: int = 0
) -> SampledModel:
    """Linearise and sample the robot of a loop.

    Args:
        context: The loop.
        measurements: Names of the measurements, in the order of y.
        pose: Arm coordinates [rad or m], shape (N,); default: home of the robot.
        segment: Which segment of piecewise linear springs, in the order of `linear_plants`.

    Raises:
        InputError: The robot has no such sensor or segment, or a sensor is without noise.
    """
    context.require(*measurements)
    chosen = None if pose is None else tuple(pose)
    return _sampled_model(context.robot, context.sample_time, tuple(measurements), chosen, segment)


@lru_cache(maxsize=8)
def _sampled_model(
    robot: Robot, sample_time: float, measurements: tuple[str, ...], pose: tuple[float, ...] | None, segment: int
) -> SampledModel:
    arm = None if pose is None else robot.check_arm(pose)
    plants = linear_plants(robot, pose=arm)
    if not -len(plants) <= segment < len(plants):
        raise InputError(
            f"spring segment {segment} of robot {robot.name} is wanted, allowed are 0 to {len(plants) - 1} "
            f"({'; '.join(plants.labels)}); choose one of them"
        )
    sampled = sampled_plants(plants, sample_time, robot.delay)
    slopes, rest = _measured(robot, measurements, arm)
    n, past = slopes.shape[1], sampled.A.shape[1] - slopes.shape[1]
    if "motor_position" in measurements or "link_position" in measurements:
        assert n == 2 * robot.n_coordinates
    return SampledModel(
        A=sampled.A[segment],
        B=sampled.B[segment],
        C=np.hstack([slopes, np.zeros((len(slopes), past))]),
        G=sampled.G[segment],
        F=sampled.F[segment],
        rest=rest,
        noise=_noise(robot, measurements),
        positions=np.array([robot.motor_rows, robot.gear_rows]),
    )


def kalman_gain(A: FloatArray, C: FloatArray, process: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the gain L of the stationary Kalman filter, x = z + L (y - C z), and the covariance of its error.

    Args:
        A: Shape (n, n).
        C: Shape (n_y, n).
        process: Covariance of the process noise, shape (n, n).
        noise: Noise of the measurements, rms, shape (n_y,).

    Returns:
        L, shape (n, n_y), and the covariance after the measurement, shape (n, n).
    """
    from scipy.linalg import solve_discrete_are  # loads slowly, and every run would wait for it

    R = np.diag(noise**2)
    scale = 1.0 / noise  # measurements in units of their noise, which keeps the equation well scaled
    ahead = solve_discrete_are(A.T, (scale[:, None] * C).T, process, np.eye(len(C)))
    gain = np.linalg.solve(C @ ahead @ C.T + R, C @ ahead).T
    after = ahead - gain @ C @ ahead
    return gain, 0.5 * (after + after.T)


def lq_gain(A: FloatArray, B: FloatArray, cost: FloatArray, effort: FloatArray) -> FloatArray:
    """Return K of u = -K x that minimises the sum of x' cost x + u' effort u, shape (M, n)."""
    from scipy.linalg import solve_discrete_are  # loads slowly

    value = solve_discrete_are(A, B, cost, effort)
    return np.asarray(np.linalg.solve(effort + B.T @ value @ B, B.T @ value @ A))


def _measured(robot: Robot, measurements: Sequence[str], arm: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Return the slopes of the measurements to [q, v] at rest, shape (n_y, 2 nq), and their values at rest."""
    model = robot.model
    n, p = robot.n_coordinates, ca.SX(ca.DM(model.parameter_values))
    x, u = ca.SX.sym("x", 2 * n), ca.SX.sym("u", robot.n_motors)
    acceleration = model.acceleration(x[:n], x[n:], u, ca.SX.zeros(6), p)[: robot.n_arm]
    qa, va, gears = x[: robot.n_arm], x[n : n + robot.n_arm], list(robot.gear_rows)
    gravity = ca.SX(ca.DM(robot.spec.gravity.value))
    of_gear = model.arm_inverse_dynamics(qa, va, acceleration, p)[gears]
    values = {
        "motor_position": model.encoder(x[: model.encoder.numel_in(0)]),
        "link_position": qa[gears],
        "joint_torque": of_gear,
        "tool_acceleration": tool_acceleration(model, qa, va, acceleration, gravity, p),
        "tool_turning_rate": turning_rate(model, qa, va, p),
    }
    indices = {sensor.measurement: list(sensor.indices) for sensor in robot.further_sensors}
    parts = [
        ca.SX(values[name]) if name == "motor_position" else ca.SX(values[name])[indices[name]] for name in measurements
    ]
    y = ca.vertcat(ca.SX(0, 1), *parts)
    rest = robot.equilibrium(arm)
    evaluate = ca.Function("measured", [x, u], [ca.densify(ca.jacobian(y, x)), ca.densify(y)])
    slopes, still = evaluate(rest, robot.holding_torque(rest))
    return np.asarray(slopes.full()), np.asarray(still.full()).ravel()


def _noise(robot: Robot, measurements: Sequence[str]) -> FloatArray:
    rms = {sensor.measurement: np.full(sensor.size, sensor.noise) for sensor in robot.further_sensors}
    rms["motor_position"] = robot.encoder_noise
    found: FloatArray = np.concatenate([rms[name] for name in measurements])
    for name in measurements:
        if not np.all(rms[name] > 0):
            raise InputError(
                f"a Kalman filter weighs measurements by their noise, but {name} of robot {robot.name} has none; state "
                "the noise of the sensor in the robot file"
            )
    return found
