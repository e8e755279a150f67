"""Observer of motors and links from the motor encoders and the accelerometer of the tool."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
from pydantic import Field

from flexros.control.model.command_line import CommandLine
from flexros.control.observers.base import AbstractObserver, Estimate
from flexros.errors import InputError
from flexros.robot.linear.held_input import held_input
from flexros.robot.spring import Spring
from flexros.robot.symbolic.inertial_coupling import solve_symmetric
from flexros.robot.symbolic.tool_sensors import tool_acceleration

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class AccelerometerObserver(AbstractObserver):
    """Observer of De Luca, Schroeder and Thuemmel (2007), see Moberg (2007), section 5.3.1.

    The accelerations a of the links follow from the accelerometer of the tool by kinematics at the estimate; then for
    each joint, with the prediction z of x = (q_m, q_m', q_a, q_a'),

        x = z + l (y - z_1),   z+ = A x + B (u, a)

    with the sampled equations M_m q_m'' = u - K (q_m - q_a) - D (q_m' - q_a') - f_m q_m' and q_a'' = a. No inertia of
    the links enters, only those of the motors, springs, dampers and kinematics. The errors of the joints are linear and
    decoupled; l puts their four poles at exp(-bandwidth T), also where the bandwidth changes while running. The
    accelerometer needs as many axes as there are links.
    """

    kind: ClassVar[str] = "accelerometer"

    bandwidth: float = Field(gt=0.0, description="magnitude of the four poles of the error of each joint [rad/s]")

    def check(self, context: LoopContext) -> None:
        """Refuse a robot without flexible joints of linear springs, or without enough axes of an accelerometer."""
        context.require("tool_acceleration")
        robot = context.robot
        if len(robot.flexible_motors) != robot.n_arm:
            raise InputError(
                f"the accelerometer observer needs a motor behind a spring in every direction, but {robot.name} has "
                f"{robot.n_arm} arm coordinates and {len(robot.flexible_motors)} such motors; choose another observer"
            )
        for joint in robot.joints:
            spring = joint.direction.spring
            if not (isinstance(spring, Spring) and spring.linear):
                raise InputError(
                    f"the accelerometer observer has linear errors, but the spring of {joint.name} of {robot.name} is "
                    "nonlinear; choose another observer"
                )
        axes = context.measurements.sizes["tool_acceleration"]
        if axes < robot.n_arm:
            raise InputError(
                f"the accelerometer of robot {robot.name} has {axes} axes, but its {robot.n_arm} links need as many; "
                "choose another observer"
            )

    def matrices(self, context: LoopContext, motor: int) -> tuple[FloatArray, FloatArray]:
        """Return A and B of (u, a) of one joint, shapes (4, 4) and (4, 2)."""
        robot, values = context.robot, context.robot.parameters
        name, joint = robot.joint_names[motor], robot.joints[robot.gear_rows[motor]].name
        inertia, friction = values[f"{name}.inertia"].value, values[f"{name}.viscous_friction"].value
        k, d = values[f"{joint}.stiffness"].value, values[f"{joint}.damping"].value
        rates = np.zeros((4, 6))
        rates[0, 1] = rates[2, 3] = rates[3, 5] = 1.0
        rates[1, :5] = np.array([-k, -d - friction, k, d, 1.0]) / inertia
        return held_input(rates[:, :4], rates[:, 4:], context.sample_time)

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states: four per joint, past commands, started."""
        return 4 * context.n_motors + CommandLine(context).size + 1

    def gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the bandwidth."""
        del context
        return {"observer.bandwidth": self.bandwidth}

    def estimate(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[Estimate, Callable[[casadi.SX], casadi.SX]]:
        """Estimate the states at a sample; see `AbstractObserver.estimate`."""
        context, m, line = signals.context, signals.context.n_motors, CommandLine(signals.context)
        names = ("motor_position", "motor_velocity", "link_position", "link_velocity")
        started, y = state[-1] > 0.5, signals.measured("motor_position")
        begin = casadi.vertcat(*[signals.reference(name) for name in names])
        z = casadi.reshape(casadi.if_else(started, state[: 4 * m], begin), m, 4)
        designs = [self.matrices(context, motor) for motor in range(m)]
        pole = casadi.exp(-gains["observer.bandwidth"] * context.sample_time)
        x = [z[k, :].T + correction(A, pole) * (y[k] - z[k, 0]) for k, (A, _) in enumerate(designs)]
        parts = [casadi.vertcat(*[joint[order] for joint in x]) for order in range(4)]
        acceleration = self._accelerations(parts[2], parts[3], signals)
        past = line.begun(state[4 * m : -1], started, signals.reference("feedforward_torque"))

        def after(command: casadi.SX) -> casadi.SX:
            torque = line.acting(past, command)
            ahead = [
                casadi.mtimes(casadi.DM(A), x[k])
                + casadi.mtimes(casadi.DM(B), casadi.vertcat(torque[k], acceleration[k]))
                for k, (A, B) in enumerate(designs)
            ]
            stacked = [joint[order] for order in range(4) for joint in ahead]
            return casadi.vertcat(*stacked, line.after(past, command), 1.0)

        return Estimate(*parts), after

    def _accelerations(self, position: casadi.SX, velocity: casadi.SX, signals: LoopSignals) -> casadi.SX:
        """Return the accelerations of the links that the accelerometer shows, in the sense of least squares."""
        robot = signals.context.robot
        axes = next(list(s.indices) for s in robot.further_sensors if s.measurement == "tool_acceleration")
        q, v, a = (casadi.SX.sym(name, robot.n_arm) for name in "qva")
        gravity = casadi.SX(casadi.DM(robot.spec.gravity.value))
        shown = tool_acceleration(robot.model, q, v, a, gravity, casadi.SX(0, 1))[axes]
        slope = casadi.jacobian(shown, a)
        evaluate = casadi.Function("shown", [q, v], [slope, casadi.substitute(shown, a, casadi.SX.zeros(a.numel()))])
        S, still = evaluate(position, velocity)
        S = casadi.densify(S)
        return solve_symmetric(casadi.mtimes(S.T, S), casadi.mtimes(S.T, signals.measured("tool_acceleration") - still))


def correction(A: FloatArray, pole: casadi.SX) -> casadi.SX:
    """Return l that puts all eigenvalues of A - A l C at a pole, by Ackermann's formula, SX (4, 1).

    Args:
        A: System matrix of a joint, shape (4, 4); the motor position, C = (1, 0, 0, 0), is measured.
        pole: The pole [1].
    """
    n = len(A)
    observability = np.vstack([np.eye(n)[:1] @ np.linalg.matrix_power(A, k) for k in range(n)])
    direction = np.linalg.solve(A, np.linalg.solve(observability, np.eye(n)[-1]))
    shifted = casadi.SX(casadi.DM(direction))
    for _ in range(n):  # (A - p I)^n
        shifted = casadi.mtimes(casadi.DM(A), shifted) - pole * shifted
    return shifted
