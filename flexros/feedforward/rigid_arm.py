"""Inverse dynamics of the arm with its elastic directions rigid, with exact derivatives."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.over_rows import over_rows
from flexros.feedforward.compensation.arm_forces import arm_forces
from flexros.feedforward.motion import Motion
from flexros.feedforward.time_stepping.dae_equations import arm_residual, motor_torque

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.robot import Robot

MAX_DERIVATIVES = 4


class RigidArm:
    """Rigid arm of a robot, in the coordinates of its gears theta, shape (M,).

    Args:
        robot: The robot.
        laws: Laws of effects that are part of the arm's equations.
    """

    def __init__(self, robot: Robot, laws: Sequence[PlacedLaw] = ()) -> None:
        self._robot = robot
        self._forces = arm_forces(robot, laws)
        self._theta = [ca.SX.sym(f"theta_{k}", robot.n_motors) for k in range(MAX_DERIVATIVES + 1)]
        self._functions: dict[tuple[int, bytes | None], ca.Function] = {}

    def _derivative(self, expression: ca.SX) -> ca.SX:
        """Return the time derivative, by directional derivatives along the derivatives of theta."""
        pairs = zip(self._theta, self._theta[1:])
        return sum((ca.jtimes(expression, low, high) for low, high in pairs), start=ca.SX.zeros(expression.shape[0]))

    def _coordinates(self, theta: ca.SX, motor: ca.SX) -> ca.SX:
        """Return all coordinates [q_a, q_m] for gear coordinates and motor coordinates."""
        robot = self._robot
        return ca.vertcat(robot.arm_from_gears(theta), *[motor[number] for number in robot.flexible_motors])

    def inverse_dynamics(self, motion: FloatArray, compliance: FloatArray | None = None) -> Motion:
        """Compute motor motion and torque for a motion of the gears, rigid or with a compliance.

        With M(theta) theta'' + n(theta, theta') = tau and the gears' compliance C = K^-1,

            q_m = theta + C tau,     u = tau + M_m q_m''     (Moberg 2007, eq. 5.4 and 5.5),

        where tau'' follows exactly by directional derivatives of the symbolic tau. The viscous friction of a motor in
        the model is added. Without compliance the gears are rigid.

        Args:
            motion: theta and its derivatives, shape (5, n, M), or (3, n, M) without compliance.
            compliance: C of each gear [rad/Nm or m/N], zero for stiff gears, shape (M,).
        """
        key = len(motion), None if compliance is None else compliance.tobytes()
        if key not in self._functions:
            self._functions[key] = self._inverse_dynamics(len(motion), compliance)
        return Motion(*over_rows(self._functions[key], *motion))

    def _inverse_dynamics(self, orders: int, compliance: FloatArray | None) -> ca.Function:
        robot, model, theta = self._robot, self._robot.model, self._theta
        rest = [self._coordinates(part, part) for part in theta[:3]]
        tau = arm_residual(model, rest[0], rest[1], rest[2], ca.SX.zeros(robot.n_motors), self._forces)
        tau = tau[list(robot.gear_rows)]
        motor = list(theta[:3])
        if compliance is not None:
            rates = [tau]
            for _ in range(2):
                rates.append(self._derivative(rates[-1]))
            motor = [gear + ca.DM(compliance) * rate for gear, rate in zip(theta, rates)]
        drive = motor_torque(
            model, rest[0], self._coordinates(motor[1], motor[1]), self._coordinates(theta[2], motor[2])
        )
        inertia = model.motor_inertia(model.parameter_values)
        torque, load, momentum = ca.SX(tau), ca.SX(tau), ca.SX.zeros(robot.n_motors)
        for i, number in enumerate(robot.flexible_motors):
            torque[number] += drive[i]
            load[number] = torque[number] - inertia[i] * motor[2][number]
            momentum[number] = inertia[i] * motor[1][number]
        encoders = [model.encoder(self._coordinates(gear, part)) for gear, part in zip(theta, motor[:2])]
        results = [robot.arm_from_gears(theta[0]), *encoders, torque, load, momentum]
        return ca.Function("inverse_dynamics", theta[:orders], [ca.densify(part) for part in results], {"cse": True})


@lru_cache(maxsize=8)
def rigid_arm(robot: Robot) -> RigidArm:
    """Return the rigid arm of a robot without laws, built once per robot."""
    return RigidArm(robot)
