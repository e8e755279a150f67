"""A robot file as the simulated real robot: its differences from the nominal robot, as values of the plant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from flexros.robot import Robot

_NOT_PHYSICS = (
    *(
        "name",
        "description",
        "source",
        "tolerance",
        "label",
        "tags",
        "drawing",
        "defaults",
        "unknown_parameters",
        "home",
    ),
    "unit",  # may be left out, and is the SI unit of its key where it is given
)
"""Keys of a robot file that change no motion."""
_ROUNDING = 1e-12
"""Relative difference of numbers after writing, reading or scaling (chosen)."""


def stand_in_values(nominal: Robot, real: Robot) -> dict[str, float]:
    """Return the parameters in which a robot differs from the nominal one.

    Args:
        nominal: The nominal robot.
        real: The robot that plays the real one.

    Returns:
        Values (SI) by name, to be used as `plant.values` of a scenario with the nominal robot.

    Raises:
        InputError: They differ in more than parameters: in structure, sensors or limits.
    """
    values = {
        name: parameter.value
        for name, parameter in real.parameters.items()
        if name in nominal.parameters and parameter.value != nominal.parameters[name].value
    } | _law_factors(nominal, real)
    if real.delay != nominal.delay:
        values["delay"] = real.delay
    made = nominal.with_values(values, f"robot {real.source}")
    where = _difference(_physics(made.spec.model_dump(mode="json")), _physics(real.spec.model_dump(mode="json")), "")
    if where:
        raise InputError(
            f"robot {real.source} cannot stand in for {nominal.name}: they differ in '{where}', which is no parameter "
            "of the equations of motion; give a file that differs from the nominal robot in such parameters only"
        )
    return values


def _law_factors(nominal: Robot, real: Robot) -> dict[str, float]:
    """List the factors between nonlinear springs, whose parameter is 1 in each robot itself."""
    factors = {}
    for number, (nominal_body, real_body) in enumerate(
        zip(nominal.spec.bodies, real.spec.bodies, strict=False), start=1
    ):
        for axis in nominal_body.directions.keys() & real_body.directions.keys():
            law, real_law = (_law(body.directions[axis].spring) for body in (nominal_body, real_body))
            if sum(law) and real_law and law != real_law:
                factors[f"body_{number}.{axis}.stiffness"] = sum(real_law) / sum(law)
    return factors


def _law(spring: object) -> tuple[float, ...]:
    """Numbers of a nonlinear spring that its factor scales; none for other springs."""
    if not isinstance(spring, Spring):
        return ()
    if spring.piecewise_linear is not None:
        return spring.piecewise_linear.slopes
    return () if spring.cubic is None else (spring.cubic.linear, spring.cubic.cubic)


def _physics(node: Any) -> Any:
    if isinstance(node, dict):
        return {key: _physics(value) for key, value in node.items() if key not in _NOT_PHYSICS}
    return [_physics(value) for value in node] if isinstance(node, (list, tuple)) else node


def _difference(one: Any, other: Any, path: str) -> str:
    """Return the first key in which two files differ, empty where they do not."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in dict.fromkeys((*one, *other)):
            inner = f"{path}.{key}" if path else str(key)
            if (key in one) != (key in other):
                return inner
            if differing := _difference(one[key], other[key], inner):
                return differing
        return ""
    if isinstance(one, list) and isinstance(other, list):
        if len(one) != len(other):
            return path
        pairs = enumerate(zip(one, other, strict=True))
        return next((key for index, pair in pairs if (key := _difference(*pair, f"{path}[{index}]"))), "")
    if isinstance(one, float) and isinstance(other, float):
        return "" if math.isclose(one, other, rel_tol=_ROUNDING) else path
    return "" if one == other else path
