"""How far the parameters of a robot may be from their nominal values before anything was measured."""

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
"""Relative standard deviation of a nominal value whose tolerance the robot file gives as zero (chosen)."""

OF_ZERO = 0.02
"""Size at which a parameter that is nominally zero may change, relative to the largest of its kind (chosen)."""

UNKNOWN = 1.0
"""Standard deviation [SI] of what the file says nothing of, as of Coulomb friction (chosen; the regression tells)."""

_DIAGONAL = INERTIA_COMPONENTS[:3]
_AT_JOINT = (
    *(f"inertia_at_joint.{entry}" for entry in INERTIA_COMPONENTS),
    *(f"first_moment.{a}" for a in "xyz"),
    "mass",
)


def prior_factor(robot: Robot, base: BaseParameters) -> FloatArray:
    """Factor of the covariance of what parameters of the regression truly are about their nominal values.

    The numbers in the robot file deviate each on its own by their tolerances, or by `PRIOR` where these are zero. The
    parameters at the joint follow from them and are correlated: a larger mass is also a larger moment. A component of
    a centre deviates by the length of the vector, a product of inertia by the largest moment of its body.

    Args:
        robot: The robot with nominal values.
        base: The base parameters.

    Returns:
        Matrix L, shape (P, P), with the covariance L L'. Parameters of one body have rows and columns of their own.
    """
    names = [parameter.name for parameter in base.standard]
    factor = np.zeros((len(names), len(names)))
    for body in (f"body_{index + 1}" for index in range(len(robot.spec.bodies))):
        places = [names.index(f"{body}.{entry}") for entry in _AT_JOINT]
        factor[np.ix_(places, places)] = _slopes(_numbers(robot, body)) * _deviations(robot, body)
    for place, name in enumerate(names):
        owner, _, kind = name.partition(".")
        known = f"{owner}.viscous_friction" if kind.startswith("viscous_friction") else name
        if known in robot.parameters and kind not in _AT_JOINT:
            factor[place, place] = _deviation(robot, known)
        if place in base.leading and not np.any(factor[place]):
            factor[place, place] = UNKNOWN
    return factor


def _numbers(robot: Robot, body: str) -> FloatArray:
    """Numbers of a body in the robot file: inertia about the centre, centre and mass, shape (10,)."""
    entries = [f"inertia.{entry}" for entry in INERTIA_COMPONENTS] + [f"center_of_mass.{axis}" for axis in "xyz"]
    return np.array([robot.parameters[f"{body}.{entry}"].value for entry in (*entries, "mass")])


def _deviations(robot: Robot, body: str) -> FloatArray:
    """Standard deviations of `_numbers`, shape (10,)."""
    numbers = _numbers(robot, body)
    length = float(np.linalg.norm(numbers[6:9]))
    moments = [_deviation(robot, f"{body}.inertia.{entry}") for entry in _DIAGONAL]
    products = [_tolerance(robot, f"{body}.inertia.{entry}") * max(numbers[:3]) for entry in INERTIA_COMPONENTS[3:]]
    centre = _tolerance(robot, f"{body}.center_of_mass.x") * length
    if length == 0:
        centre = OF_ZERO * max(
            float(np.linalg.norm(_numbers(robot, f"body_{index + 1}")[6:9])) for index in range(len(robot.spec.bodies))
        )
    return np.array([*moments, *products, centre, centre, centre, _deviation(robot, f"{body}.mass")])


def _deviation(robot: Robot, name: str) -> float:
    """Standard deviation of a number that stands for itself."""
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


def _slopes(numbers: FloatArray) -> FloatArray:
    """Derivatives of the parameters at the joint with respect to `_numbers`, shape (10, 10).

    No number enters with more than its square, so central differences are exact.
    """
    columns = [(_at_joint(numbers + side) - _at_joint(numbers - side)) / 2 for side in np.eye(10)]
    return np.stack(columns, axis=1)


def _at_joint(numbers: FloatArray) -> FloatArray:
    """Inertia at the joint, first moment and mass from the numbers of a body, shape (10,)."""
    center, mass = numbers[6:9], float(numbers[9])
    moved = inertia_at_joint(dict(zip(INERTIA_COMPONENTS, numbers[:6].tolist(), strict=True)), mass, center)
    return np.array([*moved.values(), *(mass * center), mass])
