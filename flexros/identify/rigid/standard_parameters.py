"""Standard parameters of a rigid robot, in which its torque is linear: bodies, rotors, friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.parameters import INERTIA_COMPONENTS
from flexros.robot.point_inertia import point_inertia
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

FRICTION = ("viscous_friction", "coulomb_friction", "torque_offset")
"""Friction of a motor: viscous, Coulomb, and torque offset."""

ASYMMETRIC_FRICTION = (
    "viscous_friction_forward",
    "coulomb_friction_forward",
    "viscous_friction_backward",
    "coulomb_friction_backward",
)
"""Friction of a motor by direction of motion; it contains the offset as half the difference of the Coulomb levels."""


@dataclass(frozen=True)
class StandardParameter:
    """One parameter in which the torque is linear.

    Attributes:
        name: Location and quantity, e.g. "body_2.first_moment.x" or "motor_1.coulomb_friction".
        words: Description.
        unit: SI unit.
        nominal: Nominal value; 0 for friction that the robot file does not contain.
    """

    name: str
    words: str
    unit: str
    nominal: float


def standard_parameters(
    robot: Robot, asymmetric: bool = False, *, numbers: Mapping[str, float] = MappingProxyType({})
) -> tuple[StandardParameter, ...]:
    """List the parameters of a robot, from base to tool.

    The inertial parameters of a body are its inertia at the joint L = I + m (c'c E - c c'), its first moment m c and
    its mass m (thesis 4.2.1: not the link parameters themselves, in which the torque is not linear). Of parameters
    that cannot be distinguished, the first in this order represents the others, see `base_parameters`.

    Args:
        robot: The robot, all gears and elastic directions locked.
        asymmetric: Friction by direction of motion.
        numbers: Values of the robot in place of its own, by name of the parameter [SI].

    Returns:
        Parameters: first the bodies, each followed by the inertia of its motor, then the friction of all motors, then
        that of bodies where the robot file gives one.
    """
    parameters: list[StandardParameter] = []
    value, motor = partial(_value, robot, numbers), 0
    for index, body in enumerate(robot.spec.bodies):
        name = f"body_{index + 1}"
        parameters += _of_body(name, value)
        for axis, direction in body.directions.items():
            if direction.motor is not None:
                motor += 1
                unit = unit_of("inertia", axis.startswith("r"))
                inertia = value(f"motor_{motor}.inertia")
                parameters.append(
                    StandardParameter(f"motor_{motor}.inertia", f"inertia of motor_{motor} at the arm", unit, inertia)
                )
    for index in range(robot.n_motors):
        parameters += _friction(robot, index, asymmetric, value)
    return (*parameters, *_body_friction(robot, value))


def _value(robot: Robot, numbers: Mapping[str, float], name: str) -> float:
    """Return the value of a parameter [SI]."""
    given = numbers.get(name)
    return robot.parameters[name].value if given is None else given


def _of_body(name: str, value: Callable[[str], float]) -> tuple[StandardParameter, ...]:
    center = tuple(value(f"{name}.center_of_mass.{axis}") for axis in "xyz")
    inertia = tuple(value(f"{name}.inertia.{entry}") for entry in INERTIA_COMPONENTS)
    return _body_parameters(name, value(f"{name}.mass"), center, inertia)


@lru_cache(maxsize=256)
def _body_parameters(
    name: str, mass: float, center: tuple[float, ...], inertia: tuple[float, ...]
) -> tuple[StandardParameter, ...]:
    """Compute the parameters of a body; of the sets of numbers that a fit compares, few differ in one of many bodies.

    Args:
        name: Name of the body.
        mass: Its mass [kg].
        center: Its centre of mass [m], length 3.
        inertia: Its inertia about that centre [kg m2], in the order of `INERTIA_COMPONENTS`.
    """
    at_joint = inertia_at_joint(dict(zip(INERTIA_COMPONENTS, inertia, strict=True)), mass, np.array(center))
    moment = mass * np.array(center)
    return (
        *[
            StandardParameter(
                f"{name}.inertia_at_joint.{entry}", f"inertia {entry} of {name} at its joint", "kg m2", at_joint[entry]
            )
            for entry in INERTIA_COMPONENTS
        ],
        *[
            StandardParameter(
                f"{name}.first_moment.{axis}", f"mass times centre {axis} of {name}", "kg m", float(moment[row])
            )
            for row, axis in enumerate("xyz")
        ],
        StandardParameter(f"{name}.mass", f"mass of {name}", "kg", mass),
    )


def _body_friction(robot: Robot, value: Callable[[str], float]) -> list[StandardParameter]:
    """Friction against the absolute rotation of bodies, of those bodies for which the robot file gives it."""
    names = [f"body_{index + 1}" for index in range(len(robot.spec.bodies))]
    values = {name: value(f"{name}.viscous_friction") for name in names}
    return [
        StandardParameter(
            f"{name}.viscous_friction", f"friction against the absolute rotation of {name}", "Nm s/rad", friction
        )
        for name, friction in values.items()
        if robot.parameters[f"{name}.viscous_friction"].value
    ]


def _friction(
    robot: Robot, index: int, asymmetric: bool, value: Callable[[str], float]
) -> tuple[StandardParameter, ...]:
    motor = robot.motors[index]
    kinds = ASYMMETRIC_FRICTION if asymmetric else FRICTION
    viscous = value(f"{motor.name}.viscous_friction")
    return _friction_parameters(motor.name, kinds, viscous, motor.unit("damping"), motor.torque_unit)


@lru_cache(maxsize=256)
def _friction_parameters(
    name: str, kinds: tuple[str, ...], viscous: float, damping_unit: str, torque_unit: str
) -> tuple[StandardParameter, ...]:
    """List the parameters of the friction of a motor, of which the viscous one has a nominal value [SI]."""
    parameters = []
    for kind in kinds:
        first, _, rest = kind.partition("_")
        unit = damping_unit if first == "viscous" else torque_unit
        words = f"{first} {rest.replace('_', ' ')} of {name}"
        parameters.append(StandardParameter(f"{name}.{kind}", words, unit, viscous if first == "viscous" else 0.0))
    return tuple(parameters)


def inertia_at_joint(inertia: dict[str, float], mass: float, center: FloatArray, sign: float = 1.0) -> dict[str, float]:
    """Move an inertia tensor between the centre of mass and the joint (Steiner's theorem).

    Args:
        inertia: Components [kg m2] by name.
        mass: Mass [kg].
        center: Centre of mass [m], shape (3,).
        sign: 1 from the centre to the joint, -1 back.

    Returns:
        Components [kg m2] by name.
    """
    shift = point_inertia(mass, center)
    elements = {entry: ("xyz".index(entry[0]), "xyz".index(entry[1])) for entry in INERTIA_COMPONENTS}
    return {entry: float(inertia[entry] + sign * shift[element]) for entry, element in elements.items()}
