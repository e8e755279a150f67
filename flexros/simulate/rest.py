"""States of rest of many robots that differ in parameters, without building each robot anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi
import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.model import SymbolicModel

TOLERANCE = 1e-9
"""Force that may be left, relative to the largest stiffness [N or Nm per m or rad]."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A robot at rest.

    Attributes:
        state: State x with zero speeds, shape (2 nq,).
        torque: Motor torque that holds it [Nm or N], shape (M,).
    """

    state: FloatArray
    torque: FloatArray


class RestFinder:
    """Finds where the arm hangs on its springs while the motors are held, for any parameters of a model.

    Args:
        robot: The robot that the model belongs to.
        model: Its symbolic model with free parameters.
        near: State of rest of the robot itself; its motor positions are held, shape (2 nq,).
    """

    def __init__(self, robot: Robot, model: SymbolicModel, near: FloatArray) -> None:
        self._name, self._parameter_names = robot.name, model.parameter_names
        self._near = near
        joints, nq = robot.chain.joints, robot.n_coordinates
        self._free = [i for i, one in enumerate(joints) if one.motor is None or one.motor_coordinate is not None]
        driven = [(one.motor, i, one.motor_coordinate) for i, one in enumerate(joints) if one.motor is not None]
        driven.sort()
        self._driven = [place if own is None else robot.n_arm + own for _, place, own in driven]
        q, p = casadi.SX.sym("q", nq), casadi.SX.sym("p", len(model.parameter_names))
        force = model.force(q, np.zeros(nq), np.zeros(robot.n_motors), np.zeros(6), p)
        slope = casadi.densify(casadi.jacobian(force[self._free], q)[:, self._free])
        self._force = casadi.Function("rest", [q, p], [casadi.densify(force), slope])

    def find(self, parameters: FloatArray) -> Rest:
        """Find the rest for a set of parameters.

        Args:
            parameters: Values of the model's parameters (SI), shape (n_parameters,).

        Returns:
            State and holding torque.

        Raises:
            InputError: The springs do not balance gravity.
        """
        q = self._near[: len(self._near) // 2].copy()
        force, slope = self._evaluate(q, parameters)
        for _ in range(50):
            left = force[self._free]
            if not np.any(left) or not np.all(np.isfinite(slope)):
                break
            step = np.linalg.lstsq(slope, -left, rcond=None)[0]
            q[self._free] += step
            force, slope = self._evaluate(q, parameters)
            if np.max(np.abs(step)) < 1e-13 * (1.0 + np.max(np.abs(q))):
                break
        left = force[self._free]
        if left.size and not np.max(np.abs(left)) <= TOLERANCE * (1.0 + np.max(np.abs(slope))):
            pairs = zip(self._parameter_names, parameters, strict=True)
            raise InputError(
                f"robot {self._name} finds no rest with {', '.join(f'{name} = {value:g}' for name, value in pairs)}: "
                "its springs do not balance gravity there; check the values"
            )
        return Rest(np.concatenate([q, np.zeros_like(q)]), -force[self._driven])

    def _evaluate(self, q: FloatArray, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        force, slope = self._force(q, parameters)
        return force.full().ravel(), slope.full()
