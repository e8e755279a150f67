"""Prior covariance of the parameters of a robot about their nominal values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.rigid.standard_parameters import inertia_at_joint
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.rigid.base_parameters import BaseParameters
    from flexros.robot import Robot

PRIOR = 0.2
"""Relative standard deviation of a nominal value whose tolerance in the robot file is zero (chosen)."""

OF_ZERO = 0.02
"""Typical change of a parameter that is nominally zero, relative to the largest of its kind (chosen)."""

UNKNOWN = 1.0
"""Standard deviation [SI] of parameters not in the file, e.g. Coulomb friction (chosen; the regression dominates)."""

_DIAGONAL = INERTIA_COMPONENTS[:3]
_AT_JOINT = (
    *(f"inertia_at_joint.{entry}" for entry in INERTIA_COMPONENTS),
    *(f"first_moment.{a}" for a in "xyz"),
    "mass",
)


def prior_factor(robot: Robot, base: BaseParameters) -> FloatArray:
    """Factor of the prior covariance of the regression parameters about their nominal values.

    The parameters in the robot file deviate independently by their tolerances, or by `PRIOR` where these are zero. The
    parameters at the joint follow from them and are correlated: a larger mass is also a larger moment. A component of a
    centre deviates by the length of the vector, a product of inertia by the largest moment of its body.

    Args:
        robot: The robot with nominal values.
        base: The base parameters.

    Returns:
        Matrix L, shape (P, P), with the covariance L L'; parameters of different bodies are independent.
    """
    names = [parameter.name for parameter in base.standard]
    factor = np.zeros((len(names), len(names)))
    for body in (f"body_{index + 1}" for index in range(len(robot.spec.bodies))):
        rows = [names.index(f"{body}.{entry}") for entry in _AT_JOINT]
        factor[np.ix_(rows, rows)] = _slopes(_body_parameters(robot, body)) * _deviations(robot, body)
    for row, name in enumerate(names):
        owner, _, kind = name.partition(".")
        known = f"{owner}.viscous_friction" if kind.startswith("viscous_friction") else name
        if known in robot.parameters and kind not in _AT_JOINT:
            factor[row, row] = _deviation(robot, known)
        if row in base.leading and not np.any(factor[row]):
            factor[row, row] = UNKNOWN
    return factor


def _body_parameters(robot: Robot, body: str) -> FloatArray:
    """Parameters of a body in the robot file: inertia about the centre, centre and mass, shape (10,)."""
    entries = [f"inertia.{entry}" for entry in INERTIA_COMPONENTS] + [f"center_of_mass.{axis}" for axis in "xyz"]
    return np.array([robot.parameters[f"{body}.{entry}"].value for entry in (*entries, "mass")])


def _deviations(robot: Robot, body: str) -> FloatArray:
    """Standard deviations of `_body_parameters`, shape (10,)."""
    values = _body_parameters(robot, body)
    length = float(np.linalg.norm(values[6:9]))
    moments = [_deviation(robot, f"{body}.inertia.{entry}") for entry in _DIAGONAL]
    products = [_tolerance(robot, f"{body}.inertia.{entry}") * max(values[:3]) for entry in INERTIA_COMPONENTS[3:]]
    centre = _tolerance(robot, f"{body}.center_of_mass.x") * length
    if length == 0:
        centre = OF_ZERO * max(
            float(np.linalg.norm(_body_parameters(robot, f"body_{index + 1}")[6:9]))
            for index in range(len(robot.spec.bodies))
        )
    return np.array([*moments, *products, centre, centre, centre, _deviation(robot, f"{body}.mass")])


def _deviation(robot: Robot, name: str) -> float:
    """Standard deviation of a parameter that is not part of a body's inertia."""
    value = abs(robot.parameters[name].value)
    if value > 0:
        return _tolerance(robot, name) * value
    owner, _, kind = name.partition(".")
    family = owner.split("_")[0]
    return OF_ZERO * max(
        abs(parameter.value)
        for other, parameter in robot.parameters.items()
        if other.startswith(family) and other.partition(".")[2] == kind
    )


def _tolerance(robot: Robot, name: str) -> float:
    return robot.parameters[name].tolerance or PRIOR


def _slopes(values: FloatArray) -> FloatArray:
    """Derivatives of the parameters at the joint with respect to `_body_parameters`, shape (10, 10).

    No parameter enters with more than its square, so central differences are exact.
    """
    columns = [(_at_joint(values + side) - _at_joint(values - side)) / 2 for side in np.eye(10)]
    return np.stack(columns, axis=1)


def _at_joint(values: FloatArray) -> FloatArray:
    """Inertia at the joint, first moment and mass from the parameters of a body, shape (10,)."""
    center, mass = values[6:9], float(values[9])
    moved = inertia_at_joint(dict(zip(INERTIA_COMPONENTS, values[:6].tolist(), strict=True)), mass, center)
    return np.array([*moved.values(), *(mass * center), mass])
