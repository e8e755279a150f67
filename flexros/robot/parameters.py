"""Named parameters of a robot: listing with unit, source and tolerance, and replacement of values."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.errors import unknown_name
from flexros.robot.quantity import Quantity, Vector, unit_of
from flexros.robot.specification import bending_name
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flexros.robot.specification import Body, Motor, RobotSpecification

SERVO = "servo_"
"""Beginning of the names of a motor's servo gains, after the name of the motor, e.g. "motor_1.servo_stiffness"."""

OTHER_VALUES = {
    "sample_time": ("sample_time",),
    "delay": ("delay",),
    "encoder_noise": ("sensors", "encoder_noise"),
    "tool_noise": ("sensors", "tool_noise"),
}
"""Values [s, s, rad or m, m] beside the equations of motion that can be replaced, with their keys in the robot file."""

INERTIA_COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")

GRAVITY = ("gravity.x", "gravity.y", "gravity.z")
"""Names of the components of gravity in the frame of the base [m/s2]."""
DAMPER = ".damping"
"""What the names of the dampers of springs end with."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a robot model.

    Attributes:
        name: Path in the robot, e.g. "body_3.mass", "body_1.ry.stiffness", "motor_2.inertia".
        value: Value in the SI unit.
        unit: SI unit.
        source: Origin of the value.
        tolerance: One standard deviation, relative to the value.
        path: Its keys in the robot file.
    """

    name: str
    value: float
    unit: str
    source: str
    tolerance: float
    path: tuple[str | int, ...]


def list_parameters(specification: RobotSpecification) -> dict[str, Parameter]:
    """Return all parameters of the equations of motion by name, in the order of the chain."""
    found: dict[str, Parameter] = {}
    for name, path, quantity, component in _quantities(specification):
        value = quantity.value if isinstance(quantity, Quantity) else quantity.value[component]
        default = specification.defaults.tolerance_of(length="length" in path)
        found[name] = Parameter(
            name=name,
            value=float(value),
            unit=quantity.unit,
            source=quantity.source or specification.defaults.source,
            tolerance=default if quantity.tolerance is None else quantity.tolerance,
            path=path,
        )
    return found


def _quantities(
    specification: RobotSpecification,
) -> Iterator[tuple[str, tuple[str | int, ...], Quantity | Vector, int]]:
    motor_number = 0
    gravity = specification.gravity
    known = gravity.model_copy(update={"tolerance": gravity.tolerance or 0.0})  # far better than a robot's own numbers
    for component, name in enumerate(GRAVITY):
        yield name, ("gravity", component), known, component
    for index, body in enumerate(specification.bodies):
        place: tuple[str | int, ...] = ("bodies", index)
        yield from _of_body(f"body_{index + 1}", place, body)
        for axis_name, direction in body.directions.items():
            name = f"body_{index + 1}.{axis_name}"
            here = (*place, "directions", axis_name)
            rotary = axis_name.startswith("r")
            if isinstance(direction.spring, Spring):
                yield f"{name}.stiffness", (*here, "spring"), _stiffness(direction.spring, rotary), 0
                damper = direction.damper.model_copy(update={"unit": unit_of("damping", rotary)})
                yield f"{name}.damping", (*here, "damper"), damper, 0
            if direction.zero is not None:
                zero = direction.zero.model_copy(update={"unit": unit_of("position", rotary)})
                yield f"{name}.zero", (*here, "zero"), zero, 0
            if direction.motor:
                motor_number += 1
                yield from _of_motor(f"motor_{motor_number}", (*here, "motor"), direction.motor, rotary)
        for axis, bending in body.bending.items():
            for number, mode in enumerate(bending.listed()):
                name, here = bending_name(index, axis, number), (*place, "bending", axis, "modes", number)
                yield f"{name}.stiffness", (*here, "stiffness"), mode.stiffness, 0
                yield f"{name}.damping", (*here, "damping"), mode.damping, 0


def _stiffness(spring: Spring, rotary: bool) -> Quantity:
    """Return the stiffness of a linear spring, or the factor (nominally 1) on a nonlinear law."""
    if spring.stiffness is not None:
        return spring.stiffness.model_copy(update={"unit": unit_of("stiffness", rotary)})
    law = spring.piecewise_linear or spring.cubic
    assert law is not None
    return Quantity(value=1.0, unit="1", source=law.source, tolerance=law.tolerance)


def _of_body(
    name: str, place: tuple[str | int, ...], body: Body
) -> Iterator[tuple[str, tuple[str | int, ...], Quantity | Vector, int]]:
    yield f"{name}.mass", (*place, "mass"), body.mass, 0
    for component, axis in enumerate("xyz"):
        yield f"{name}.center_of_mass.{axis}", (*place, "center_of_mass", component), body.center_of_mass, component
    for entry in INERTIA_COMPONENTS:
        yield f"{name}.inertia.{entry}", (*place, "inertia", entry), getattr(body.inertia, entry), 0
    for component, axis in enumerate("xyz"):
        yield f"{name}.length.{axis}", (*place, "length", component), body.length, component
    yield f"{name}.viscous_friction", (*place, "viscous_friction"), body.viscous_friction, 0


def _of_motor(
    name: str, place: tuple[str | int, ...], motor: Motor, rotary: bool
) -> Iterator[tuple[str, tuple[str | int, ...], Quantity | Vector, int]]:
    inertia = motor.inertia.model_copy(update={"unit": unit_of("inertia", rotary)})
    yield f"{name}.inertia", (*place, "inertia"), inertia, 0
    friction = motor.viscous_friction.model_copy(update={"unit": unit_of("damping", rotary)})
    yield f"{name}.viscous_friction", (*place, "viscous_friction"), friction, 0
    if motor.servo is not None:
        here = (*place, "servo")
        for key in ("stiffness", "damping", "integral"):
            gain = getattr(motor.servo, key).model_copy(update={"unit": unit_of(key, rotary)})
            gain = gain.model_copy(update={"tolerance": 0.0}) if motor.servo.known else gain
            yield f"{name}.{SERVO}{key}", (*here, key), gain, 0
        exact = motor.servo.feedforward.model_copy(update={"tolerance": motor.servo.feedforward.tolerance or 0.0})
        yield f"{name}.{SERVO}feedforward", (*here, "feedforward"), exact, 0


def with_values(
    data: Mapping[str, Any], specification: RobotSpecification, values: Mapping[str, float], source: str
) -> dict[str, Any]:
    """Return the data of a robot file with values replaced, to be validated again.

    Args:
        data: Robot file as dumped by `RobotSpecification.model_dump`.
        specification: The same, validated.
        values: New values by parameter name (SI); also of `OTHER_VALUES`.
        source: Origin of the change; prefix of the error message.

    Raises:
        InputError: A name is not a parameter of the robot.
    """
    known = list_parameters(specification)
    changed = copy.deepcopy(dict(data))
    for name, value in values.items():
        if name in OTHER_VALUES:
            *way, last = OTHER_VALUES[name]
            here = changed
            for step in way:
                here = here[step]
            here[last]["value"] = value
            continue
        if name not in known:
            raise unknown_name(f"parameter of robot {specification.name}", name, [*known, *OTHER_VALUES], source)
        _set(changed, known[name], value)
    return changed


def _set(data: dict[str, Any], parameter: Parameter, value: float) -> None:
    *way, last = parameter.path
    here: Any = data
    for step in way:
        here = here[step]
    if isinstance(last, int):  # a component of a vector
        components = list(here["value"])
        components[last] = value
        here["value"] = tuple(components)
        return
    target = here.setdefault(last, {})  # an integral of zero is left out
    if last == "spring" and target["stiffness"] is None:
        _scale_law(target, value)
    elif last == "spring":
        target["stiffness"]["value"] = value
    else:
        target["value"] = value


def _scale_law(spring: dict[str, Any], factor: float) -> None:
    if spring["piecewise_linear"] is not None:
        law = spring["piecewise_linear"]
        law["slopes"] = tuple(factor * slope for slope in law["slopes"])
    else:
        law = spring["cubic"]
        law["linear"], law["cubic"] = factor * law["linear"], factor * law["cubic"]
