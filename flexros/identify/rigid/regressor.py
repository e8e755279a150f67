"""Regressor H of the torque of a rigid robot (Moberg 2007, eq. 4.11)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.standard_parameters import FRICTION, standard_parameters
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

_CHUNK = 500
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
        parameters: Parameters of the columns, length P.
    """

    def __init__(self, robot: Robot, asymmetric: bool = False) -> None:
        if any(body.bending for body in robot.spec.bodies):
            raise InputError(
                f"robot {robot.name} has links that bend, whose mass is spread over them; the torque regression needs "
                "rigid links: give the links their inertia instead of bending"
            )
        self.robot = robot
        self.parameters = standard_parameters(robot, asymmetric)
        self._motion = tuple(ca.SX.sym(name, robot.n_motors) for name in "qva")
        self._columns = self._all_columns(asymmetric)
        self._functions: dict[tuple[int, ...], ca.Function] = {}

    def matrix(self, q: FloatArray, v: FloatArray, a: FloatArray, columns: Sequence[int] | None = None) -> FloatArray:
        """Evaluate the regressor.

        Args:
            q: Motor positions [rad or m], shape (n, M).
            v: Speeds, shape (n, M).
            a: Accelerations, shape (n, M).
            columns: Indices of k columns; default: all.

        Returns:
            H, shape (n, M, k).
        """
        chosen = tuple(range(len(self.parameters)) if columns is None else columns)
        n, motors = q.shape
        H = np.empty((-(-n // _CHUNK) * _CHUNK, motors, len(chosen)))
        motion = np.zeros((3, len(H), motors))
        motion[:, :n] = q, v, a
        buffer, evaluate = cast("tuple[Any, Callable[[], None]]", self._function(chosen).buffer())
        for first in range(0, n, _CHUNK):
            rows = slice(first, first + _CHUNK)
            for argument, signal in enumerate(motion[:, rows]):
                buffer.set_arg(argument, signal.data)
            buffer.set_res(0, H[rows].data)
            evaluate()
        return H[:n]

    def _function(self, columns: tuple[int, ...]) -> ca.Function:
        """Function from (q, v, a) of a chunk to the rows of some columns."""
        if columns not in self._functions:
            rows = ca.vec(ca.densify(self._columns[:, list(columns)]).T)
            sample = ca.Function("regressor", list(self._motion), [rows], {"cse": True})
            self._functions[columns] = sample.map(_CHUNK)
        return self._functions[columns]

    def _all_columns(self, asymmetric: bool) -> ca.SX:
        """Columns of all parameters as symbols, shape (M, P)."""
        robot = self.robot
        column = {parameter.name: index for index, parameter in enumerate(self.parameters)}
        H = ca.SX(robot.n_motors, len(self.parameters))
        H[:, [column[_linear_name(name)] for name in body_names(robot)]] = _body_columns(robot, *self._motion)
        coupled = robot.flexible_motors if robot.spec.inertial_coupling else ()
        if coupled:
            H[:, [column[f"motor_{k + 1}.inertia"] for k in coupled]] = _rotor_columns(robot, *self._motion)
        _, v, a = self._motion
        for motor in range(robot.n_motors):
            name = f"motor_{motor + 1}"
            if motor not in coupled:
                H[motor, column[f"{name}.inertia"]] = a[motor]
            for kind, value in _friction_columns(v[motor], asymmetric).items():
                H[motor, column[f"{name}.{kind}"]] = value
        return H


def _friction_columns(v: ca.SX, asymmetric: bool) -> dict[str, ca.SX]:
    """Columns of the friction of a motor at its speed."""
    if not asymmetric:
        return dict(zip(FRICTION, (v, ca.sign(v), ca.SX(1.0)), strict=True))
    columns = {}
    for direction, moving in (("forward", v > 0), ("backward", v < 0)):
        columns[f"viscous_friction_{direction}"] = v * moving
        columns[f"coulomb_friction_{direction}"] = ca.sign(v) * moving
    return columns


def body_names(robot: Robot) -> list[str]:
    """Return the names of the robot parameters that the torque of the bodies depends on.

    Args:
        robot: The robot.
    """
    kinds = [
        *[f"inertia.{entry}" for entry in INERTIA_COMPONENTS],
        *[f"center_of_mass.{axis}" for axis in "xyz"],
        "mass",
    ]
    names = [f"body_{index + 1}" for index in range(len(robot.spec.bodies))]
    friction = [f"{name}.viscous_friction" for name in names if robot.parameters[f"{name}.viscous_friction"].value]
    return [*[f"{name}.{kind}" for name in names for kind in kinds], *friction]


def _linear_name(name: str) -> str:
    """Name of the standard parameter whose column the derivative is."""
    return name.replace(".inertia.", ".inertia_at_joint.").replace(".center_of_mass.", ".first_moment.")


def _body_columns(robot: Robot, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    """Columns of the bodies, shape (M, 10 R and more)."""
    names = body_names(robot)
    model = robot.symbolic(names)
    p = ca.SX.sym("p", len(names))
    arm = robot.arm_from_gears
    tau = model.arm_inverse_dynamics(arm(q), arm(v), arm(a), p)[list(robot.gear_rows)]
    unit = ca.DM([1.0 if name.endswith(".mass") else 0.0 for name in names])
    return ca.substitute(ca.jacobian(tau, p), p, unit)


def _rotor_columns(robot: Robot, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    """Columns of the rotors behind flexible gears, with their coupling to the arm."""
    flexible = robot.flexible_motors
    model = robot.symbolic([f"motor_{motor + 1}.inertia" for motor in flexible])
    p = ca.SX.sym("p", len(flexible))
    whole = [ca.vertcat(robot.arm_from_gears(x), *[x[motor] for motor in flexible]) for x in (q, v, a)]
    force = model.force(whole[0], whole[1], ca.SX.zeros(robot.n_motors), ca.SX.zeros(6), p)
    torque = model.mass_matrix(whole[0], p) @ whole[2] - force
    tau = torque[list(robot.gear_rows)]
    for row, motor in enumerate(flexible):
        tau[motor] += torque[robot.n_arm + row]
    return ca.jacobian(tau, p)
