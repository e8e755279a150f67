"""Extended Kalman filter on the nonlinear model of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
from pydantic import Field

from flexros.control.model.command_line import CommandLine
from flexros.control.observers.base import AbstractObserver, Estimate
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals

MOST_STATES = 16
"""Largest number of states [1], chosen: the covariance takes n^3 operations in every sample."""


class ExtendedKalman(AbstractObserver):
    """Extended Kalman filter on all coordinates and rates of the robot (Moberg 2007, section 5.3.1, footnote).

        L = P C' (C P C' + R)^-1,   x = z + L (y - C z),   P = (I - L C) P
        z+ = x after a Runge-Kutta step of the model under the command that acts,   P+ = F P F' + Q

    F = I + T J + T^2 J^2 / 2 with the Jacobian J of the model at x; y are the encoders of the motors, and of the links
    where the robot has them, R their noise in the robot file. Q holds white torques at motors and links, over a sample.
    The filter starts at the first reference, with the given uncertainty. It needs no feedforward torque.
    """

    kind: ClassVar[str] = "extended_kalman"

    torque_noise: float = Field(gt=0.0, description="white torque at every motor, rms over a sample [Nm]")
    load_noise: float = Field(gt=0.0, description="white torque on every arm coordinate, rms over a sample [Nm]")
    start_position: float = Field(default=1e-3, gt=0.0, description="uncertainty of the start positions, rms [rad]")
    start_speed: float = Field(default=1e-2, gt=0.0, description="uncertainty of the start speeds, rms [rad/s]")

    def check(self, context: LoopContext) -> None:
        """Refuse a robot of too many states, or without noise of its encoders."""
        n = 2 * context.robot.n_coordinates
        if n > MOST_STATES:
            raise InputError(
                f"an extended Kalman filter of {n} states is wanted for robot {context.robot.name}, allowed are "
                f"{MOST_STATES}, because its covariance takes {n}^3 operations per sample; choose the observer kalman"
            )
        if not np.all(self._noise(context) > 0):
            raise InputError(
                f"a Kalman filter weighs encoders by their noise, but one of robot {context.robot.name} has none; "
                "state it in the robot file"
            )

    def _links(self, context: LoopContext) -> bool:
        return context.measurements.sizes.get("link_position", 0) == context.n_motors

    def _noise(self, context: LoopContext) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        links = [sensor.noise for sensor in context.robot.further_sensors if sensor.measurement == "link_position"]
        more = np.full(context.n_motors, links[0]) if self._links(context) else np.zeros(0)
        return np.concatenate([context.robot.encoder_noise, more])

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states: prediction z, lower triangle of its covariance, past commands, started."""
        n = 2 * context.robot.n_coordinates
        return n + n * (n + 1) // 2 + CommandLine(context).size + 1

    def gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the levels of the process noise."""
        del context
        return {"observer.torque_noise": self.torque_noise, "observer.load_noise": self.load_noise}

    def estimate(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[Estimate, Callable[[casadi.SX], casadi.SX]]:
        """Estimate the states at a sample; see `AbstractObserver.estimate`."""
        context = signals.context
        robot, n, line = context.robot, 2 * context.robot.n_coordinates, CommandLine(context)
        size = n * (n + 1) // 2
        begin, spread = self._start(signals)
        started = state[-1] > 0.5
        z = casadi.if_else(started, state[:n], begin)
        P = _full(casadi.if_else(started, state[n : n + size], spread), n)
        past = line.begun(state[n + size : -1], started, signals.reference("feedforward_torque"))
        x, P = self._corrected(z, P, signals)
        motors, gears, half = list(robot.motor_rows), list(robot.gear_rows), n // 2
        found = Estimate(x[motors], x[[row + half for row in motors]], x[gears], x[[row + half for row in gears]])

        def after(command: casadi.SX) -> casadi.SX:
            torque = line.acting(past, command)
            moved, covariance = self._predicted(x, P, torque, context, gains)
            return casadi.vertcat(moved, _lower(covariance), line.after(past, command), 1.0)

        return found, after

    def _start(self, signals: LoopSignals) -> tuple[casadi.SX, casadi.SX]:
        """Return state and lower triangle of the covariance before the first sample, from its reference."""
        robot = signals.context.robot
        n = robot.n_coordinates
        q, v = casadi.SX.zeros(n), casadi.SX.zeros(n)
        for motor in range(robot.n_motors):
            for rows, name in ((robot.gear_rows, "link"), (robot.motor_rows, "motor")):
                q[rows[motor]] = signals.reference(f"{name}_position")[motor]
                v[rows[motor]] = signals.reference(f"{name}_velocity")[motor]
        spread = casadi.DM([self.start_position**2] * n + [self.start_speed**2] * n)
        return casadi.vertcat(q, v), _lower(casadi.SX(casadi.diag(spread)))

    def _corrected(self, z: casadi.SX, P: casadi.SX, signals: LoopSignals) -> tuple[casadi.SX, casadi.SX]:
        """Correct state and covariance by the encoders, one after the other: their noises are independent."""
        context = signals.context
        robot = context.robot
        rows = [*robot.motor_rows, *(robot.gear_rows if self._links(context) else ())]
        y = [signals.measured("motor_position")]
        if self._links(context):
            y.append(signals.measured("link_position"))
        for row, value, noise in zip(rows, casadi.vertsplit(casadi.vertcat(*y)), self._noise(context), strict=True):
            gain = P[:, row] / (P[row, row] + noise**2)
            z = z + gain * (value - z[row])
            P = P - casadi.mtimes(gain, P[row, :])
        return z, P

    def _predicted(
        self, x: casadi.SX, P: casadi.SX, torque: casadi.SX, context: LoopContext, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, casadi.SX]:
        """Return state and covariance at the next sample."""
        model, T, n = context.robot.model, context.sample_time, x.numel()
        s, u = casadi.SX.sym("s", n), casadi.SX.sym("u", context.n_motors)
        rate = casadi.Function("rate", [s, u], [model.derivative(s, u, np.zeros(6), model.parameter_values)])
        k1 = rate(x, torque)
        k2 = rate(x + 0.5 * T * k1, torque)
        k3 = rate(x + 0.5 * T * k2, torque)
        k4 = rate(x + T * k3, torque)
        slope = casadi.Function("slope", [s, u], [casadi.jacobian(rate(s, u), s), casadi.jacobian(rate(s, u), u)])
        J, B = slope(x, torque)
        F = casadi.SX.eye(n) + T * J + 0.5 * T**2 * casadi.mtimes(J, J)
        half, n_arm = n // 2, context.robot.n_arm
        inertia = model.arm_inertia(x[:n_arm], model.parameter_values)
        pushed = casadi.SX.zeros(n, n_arm)
        pushed[half : half + n_arm, :] = casadi.inv_minor(inertia) if n_arm < 4 else casadi.inv(inertia)
        step = T * casadi.SX.eye(n) + 0.5 * T**2 * J  # a torque held over the sample moves the positions too
        by_motor = casadi.mtimes(step, B) * gains["observer.torque_noise"]
        by_load = casadi.mtimes(step, pushed) * gains["observer.load_noise"]
        Q = casadi.mtimes(by_motor, by_motor.T) + casadi.mtimes(by_load, by_load.T)
        return x + T / 6 * (k1 + 2 * k2 + 2 * k3 + k4), casadi.mtimes([F, P, F.T]) + Q


def _lower(matrix: casadi.SX) -> casadi.SX:
    """Return the lower triangle of a symmetric matrix, column by column."""
    n = matrix.shape[0]
    return casadi.vertcat(*[casadi.densify(matrix[column:, column]) for column in range(n)])


def _full(lower: casadi.SX, n: int) -> casadi.SX:
    """Return a symmetric matrix from its lower triangle."""
    matrix, begin = casadi.SX.zeros(n, n), 0
    for column in range(n):
        part = lower[begin : begin + n - column]
        matrix[column:, column], matrix[column, column:] = part, part.T
        begin += n - column
    return matrix
