"""Torque that the motors of a rigid robot need against a law of the arm, such as the error of a weight, in a motion."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.over_rows import over_rows
from flexros.effects.kinds.arm_law import ArmState
from flexros.identify.rigid.regressor import body_names
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.arm_law import AbstractArmLaw
    from flexros.robot import Robot

LAWS = 32
"""Laws of robots that are kept (chosen)."""


def arm_law_torque(
    robot: Robot, law: AbstractArmLaw, location: str, position: FloatArray, numbers: Mapping[str, float]
) -> FloatArray:
    """Return the torque -F in the gears against the force F of a law without own states, at standstill.

    Args:
        robot: The robot; its gears and elastic directions count as locked.
        law: The law.
        location: Its location.
        position: Motor positions [rad or m], shape (n, M).
        numbers: Values of the robot in place of its own, by name of the parameter [SI].

    Returns:
        Torques [Nm or N], shape (n, M).
    """
    values = [numbers.get(name, robot.parameters[name].value) for name in (*body_names(robot), *GRAVITY)]
    given = np.array([*law.parameter_values.values(), *values])
    (torque,) = over_rows(_torque_of(robot, type(law), location), position, np.tile(given, (len(position), 1)))
    return torque


@lru_cache(maxsize=LAWS)
def _torque_of(robot: Robot, kind: type[AbstractArmLaw], location: str) -> ca.Function:
    """Build that torque as a function of motor positions, and of the law, the bodies and gravity."""
    names = [*body_names(robot), *GRAVITY]
    model, own = robot.symbolic(names), tuple(kind.model_construct().parameter_values)
    gears, given = ca.SX.sym("gears", robot.n_motors), ca.SX.sym("given", len(own) + len(names))
    position = robot.arm_from_gears(gears)
    arm = ArmState.of_arm(robot, location, position, ca.SX.zeros(robot.n_arm), model, given[len(own) :])
    force = kind.model_construct().force(arm, dict(zip(own, ca.vertsplit(given)[: len(own)], strict=True)))
    return ca.Function("arm_law_torque", [gears, given], [ca.densify(-force[list(robot.gear_rows)])], {"cse": True})
