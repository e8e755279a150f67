"""Regressor H of the torque of a rigid robot (Moberg 2007, eq. 4.11)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.identify.rigid.standard_parameters import FRICTION, standard_parameters
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

_CHUNK = 1000
"""Samples evaluated at once (chosen: some tens of MB for a six-axis robot)."""


class RigidRegressor:
    """tau = H(q, q', q'') pi for a robot whose gears and elastic directions are locked (eq. 4.11).

    The columns of the bodies are the derivatives of the symbolic inverse dynamics with respect to masses, centres and
    inertias at m = 1, c = 0, I = 0, where they are those of m, m c and of the inertia at the joint. Rotor inertia,
    viscous and Coulomb friction and offset act on their own motor only; with the inertial coupling of the rotors
    (eq. 3.12) their columns follow from the whole model as well.

    Args:
        robot: The robot.
        asymmetric: Friction by direction of motion.

    Attributes:
        robot: The robot.
        parameters: What the columns belong to, length P.
    """

    def __init__(self, robot: Robot, asymmetric: bool = False) -> None:
        self.robot = robot
        self.parameters = standard_parameters(robot, asymmetric)
        self._column = {parameter.name: place for place, parameter in enumerate(self.parameters)}
        self._bodies = _body_columns(robot)
        self._rotors = _rotor_columns(robot) if robot.spec.inertial_coupling else None
        self._asymmetric = asymmetric

    def matrix(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Evaluate the regressor.

        Args:
            q: Motor positions [rad or m], shape (n, M).
            v: Speeds, shape (n, M).
            a: Accelerations, shape (n, M).

        Returns:
            H, shape (n, M, P).
        """
        n, motors = q.shape
        H = np.zeros((n, motors, len(self.parameters)))
        names = _body_names(self.robot)
        places = [self._column[_linear_name(name)] for name in names]
        for first in range(0, n, _CHUNK):
            rows = slice(first, min(first + _CHUNK, n))
            arguments = (q[rows].T, v[rows].T, a[rows].T)
            H[rows, :, places] = _unstack(self._bodies(*arguments), motors, len(names))
            if self._rotors is not None:
                columns = [self._column[f"motor_{k + 1}.inertia"] for k in self.robot.chain.flexible_motors]
                H[rows, :, columns] = _unstack(self._rotors(*arguments), motors, len(columns))
        for motor in range(motors):
            self._motor_columns(H[:, motor], motor, v[:, motor], a[:, motor])
        return H

    def _motor_columns(self, rows: FloatArray, motor: int, v: FloatArray, a: FloatArray) -> None:
        """Fill the columns of one motor into its rows, shape (n, P)."""
        name = f"motor_{motor + 1}"
        if self._rotors is None or motor not in self.robot.chain.flexible_motors:
            rows[:, self._column[f"{name}.inertia"]] = a
        if not self._asymmetric:
            for kind, values in zip(FRICTION, (v, np.sign(v), np.ones_like(v)), strict=True):
                rows[:, self._column[f"{name}.{kind}"]] = values
            return
        for direction, moving in (("forward", v > 0), ("backward", v < 0)):
            rows[:, self._column[f"{name}.viscous_friction_{direction}"]] = v * moving
            rows[:, self._column[f"{name}.coulomb_friction_{direction}"]] = np.sign(v) * moving


def _body_names(robot: Robot) -> list[str]:
    """Names of the robot's parameters whose derivatives are columns of the bodies."""
    kinds = [
        *[f"inertia.{entry}" for entry in INERTIA_COMPONENTS],
        *[f"center_of_mass.{axis}" for axis in "xyz"],
        "mass",
    ]
    names = [f"body_{index + 1}" for index in range(len(robot.spec.bodies))]
    rubbing = [f"{name}.viscous_friction" for name in names if robot.parameters[f"{name}.viscous_friction"].value]
    return [*[f"{name}.{kind}" for name in names for kind in kinds], *rubbing]


def _linear_name(name: str) -> str:
    """Name of the standard parameter whose column the derivative is."""
    return name.replace(".inertia.", ".inertia_at_joint.").replace(".center_of_mass.", ".first_moment.")


def _body_columns(robot: Robot) -> ca.Function:
    """Function from (q, v, a), shape (M, 1) each, to the columns of the bodies, shape (M, 10 R and more)."""
    names = _body_names(robot)
    model = robot.symbolic(names)
    q, v, a = (ca.SX.sym(name, robot.n_motors) for name in "qva")
    p = ca.SX.sym("p", len(names))
    arm = robot.chain.arm_from_gears
    tau = model.arm_inverse_dynamics(arm(q), arm(v), arm(a), p)[list(robot.chain.geared)]
    unit = ca.DM([1.0 if name.endswith(".mass") else 0.0 for name in names])
    columns = ca.substitute(ca.jacobian(tau, p), p, unit)
    return ca.Function("body_columns", [q, v, a], [ca.densify(columns)], {"cse": True})


def _rotor_columns(robot: Robot) -> ca.Function:
    """Function from (q, v, a) to the columns of the rotors behind flexible gears, with their coupling to the arm."""
    flexible = robot.chain.flexible_motors
    model = robot.symbolic([f"motor_{number + 1}.inertia" for number in flexible])
    q, v, a = (ca.SX.sym(name, robot.n_motors) for name in "qva")
    p = ca.SX.sym("p", len(flexible))
    whole = [ca.vertcat(robot.chain.arm_from_gears(x), *[x[number] for number in flexible]) for x in (q, v, a)]
    force = model.force(whole[0], whole[1], ca.SX.zeros(robot.n_motors), ca.SX.zeros(6), p)
    need = model.mass_matrix(whole[0], p) @ whole[2] - force
    tau = need[list(robot.chain.geared)]
    for place, number in enumerate(flexible):
        tau[number] += need[robot.n_arm + place]
    return ca.Function("rotor_columns", [q, v, a], [ca.densify(ca.jacobian(tau, p))], {"cse": True})


def _unstack(result: ca.DM, rows: int, columns: int) -> FloatArray:
    """Take the matrices of many samples, side by side, apart: shape (n, rows, columns)."""
    stacked = np.array(result).reshape(rows, -1, columns)
    return np.ascontiguousarray(stacked.transpose(1, 0, 2))
