"""Torque that the bodies of a rigid robot need in a motion, as machine code."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_samples import FunctionOverSamples
from flexros.identify.rigid.regressor import body_names
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

LANES = 8
"""Samples that are evaluated in parallel."""


class BodyTorque:
    """tau = H(q, q', q'') pi without rotors and friction of motors (Moberg 2007, eq. 4.11), pi of any bodies.

    Gravity may be any, too. The regressor H, which has a column of every parameter, takes far longer.

    Args:
        robot: The robot; its gears and elastic directions count as locked.
    """

    def __init__(self, robot: Robot) -> None:
        names, arm = [*body_names(robot), *GRAVITY], robot.arm_from_gears
        self._nominal = {name: robot.parameters[name].value for name in names}
        model = robot.symbolic(names)
        motion, values = ca.SX.sym("motion", 3 * robot.n_motors), ca.SX.sym("values", len(names))
        q, v, a = map(arm, ca.vertsplit(motion, robot.n_motors))
        torque = model.arm_inverse_dynamics(q, v, a, values)[list(robot.gear_rows)]
        inputs = [motion, ca.SX(0, 1), values]
        self._torque = FunctionOverSamples(ca.Function("body_torque", inputs, [torque], {"cse": True}), LANES)

    def __call__(
        self, position: FloatArray, velocity: FloatArray, acceleration: FloatArray, numbers: Mapping[str, float]
    ) -> FloatArray:
        """Evaluate the torque at n samples.

        Args:
            position: Motor positions [rad or m], shape (n, M).
            velocity: Speeds, shape (n, M).
            acceleration: Accelerations, shape (n, M).
            numbers: Values of the robot in place of its own, by name of the parameter [SI]; those of other things than
                bodies and gravity do not count.

        Returns:
            Torques [Nm or N], shape (n, M).
        """
        n, motors = position.shape
        motion = np.zeros((-(-n // LANES) * LANES, 3 * motors))
        motion[:n] = np.hstack([position, velocity, acceleration])
        side_by_side = motion.reshape(-1, LANES, 3 * motors).transpose(0, 2, 1)
        values = np.array([numbers.get(name, value) for name, value in self._nominal.items()])
        torque = self._torque(side_by_side, np.empty((len(side_by_side), 0, LANES)), values[:, None])
        return torque.transpose(0, 2, 1).reshape(-1, motors)[:n]


@lru_cache(maxsize=4)
def body_torque(robot: Robot) -> BodyTorque:
    """Return the torque of the bodies of a robot, compiled once.

    Args:
        robot: The robot.
    """
    return BodyTorque(robot)
