"""Unknown parameters in the linear model: springs, dampers and motors as rank-one terms, others as matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.robot.robot import Robot
    from flexros.robot.symbolic.chain import Joint

MATRIX = -1
"""Power of a parameter that is not a rank-one term."""
_STIFFNESS, _DAMPING, _INERTIA = 0, 1, 2


@dataclass(frozen=True, eq=False)
class ParameterTerms:
    """Terms of the parameters in A(jw) = -w^2 M + jw D + K.

    A rank-one parameter adds theta_p s_p (jw)^power b_p b_p^T, with s_p = 1 except for nonlinear springs.

    Attributes:
        vectors: b, zero for a parameter that is not a rank-one term, shape (P, n).
        powers: 0 stiffness, 1 damping or friction, 2 motor inertia, MATRIX for all others, shape (P,).
        springs: Laws of the parameters that scale a nonlinear spring, by index among the parameters.
    """

    vectors: FloatArray
    powers: IntArray
    springs: dict[int, Spring]

    def factors(self, q: ca.SX) -> ca.SX:
        """Return s_p, SX (P, 1), as functions of the coordinates q: the slope of a nonlinear spring, else 1."""
        factors = ca.SX.ones(len(self.powers))
        for index, spring in self.springs.items():
            deflection = ca.SX.sym("deflection")
            slope = ca.jacobian(spring.force(deflection, 1.0), deflection)
            stretch = ca.dot(ca.SX(self.vectors[index]), q)
            factors[index] = ca.substitute(slope, deflection, stretch)
        return factors


def parameter_terms(robot: Robot, names: Sequence[str]) -> ParameterTerms:
    """Return the terms of some parameters.

    Raises:
        InputError: A parameter is named twice.
    """
    if len(set(names)) < len(names):
        twice = sorted({name for name in names if list(names).count(name) > 1})
        raise InputError(f"unknown parameters name {', '.join(twice)} more than once; name each only once")
    vectors = np.zeros((len(names), robot.n_coordinates))
    powers = np.full(len(names), MATRIX)
    springs: dict[int, Spring] = {}
    known = _rank_one(robot)
    for index, name in enumerate(names):
        if name not in known:
            continue
        vectors[index], powers[index], joint = known[name]
        spring = joint.direction.spring
        if powers[index] == _STIFFNESS and isinstance(spring, Spring) and not spring.linear:
            springs[index] = spring
    return ParameterTerms(vectors, powers.astype(np.int64), springs)


def _rank_one(robot: Robot) -> dict[str, tuple[FloatArray, int, Joint]]:
    """Return vector, power and joint of all parameters that are rank-one terms."""
    unit = np.eye(robot.n_coordinates)
    found: dict[str, tuple[FloatArray, int, Joint]] = {}
    for index, joint in enumerate(robot.joints):
        motor = None if joint.motor is None else robot.motor_rows[joint.motor]
        if isinstance(joint.direction.spring, Spring):
            stretch = unit[index] if motor is None else unit[motor] - unit[index]
            found[f"{joint.name}.stiffness"] = (stretch, _STIFFNESS, joint)
            found[f"{joint.name}.damping"] = (stretch, _DAMPING, joint)
        if joint.motor is not None and motor is not None:
            name = f"motor_{joint.motor + 1}"
            found[f"{name}.viscous_friction"] = (unit[motor], _DAMPING, joint)
            if not robot.spec.inertial_coupling:  # else it also enters the coupling
                found[f"{name}.inertia"] = (unit[motor], _INERTIA, joint)
    return found
