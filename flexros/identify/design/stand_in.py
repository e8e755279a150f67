"""A simulated robot that stands in for the real one: what differs from the nominal robot, as values of the plant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.robot import Robot

_NOT_PHYSICS = ("name", "description", "source", "tolerance", "label", "tags", "defaults", "unknown_parameters", "home")
"""Keys of a robot file that change no motion."""


def stand_in_values(nominal: Robot, real: Robot) -> dict[str, float]:
    """List the numbers in which a robot differs from the nominal one.

    Args:
        nominal: The robot as it is thought to be.
        real: The robot that plays the real one.

    Returns:
        Values (SI) by name, to be used as `plant.values` of a scenario with the nominal robot.

    Raises:
        InputError: They differ in more than numbers: in structure, sensors or limits.
    """
    values = {
        name: one.value
        for name, one in real.parameters.items()
        if name in nominal.parameters and one.value != nominal.parameters[name].value
    }
    if real.delay != nominal.delay:
        values["delay"] = real.delay
    made = nominal.with_values(values, f"robot {real.source}")
    where = _difference(_physics(made.spec.model_dump(mode="json")), _physics(real.spec.model_dump(mode="json")), "")
    if where:
        raise InputError(
            f"robot {real.source} cannot stand in for {nominal.name}: they differ in '{where}', which is no number of "
            "the equations of motion; give a file that differs from the nominal robot in such numbers only"
        )
    return values


def _physics(node: Any) -> Any:
    if isinstance(node, dict):
        return {key: _physics(value) for key, value in node.items() if key not in _NOT_PHYSICS}
    return [_physics(value) for value in node] if isinstance(node, (list, tuple)) else node


def _difference(one: Any, other: Any, path: str) -> str:
    """Return the first key in which two files differ, empty where they do not."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in dict.fromkeys((*one, *other)):
            place = f"{path}.{key}" if path else str(key)
            if (key in one) != (key in other):
                return place
            if found := _difference(one[key], other[key], place):
                return found
        return ""
    if isinstance(one, list) and isinstance(other, list):
        if len(one) != len(other):
            return path
        pairs = enumerate(zip(one, other, strict=True))
        return next((found for place, pair in pairs if (found := _difference(*pair, f"{path}[{place}]"))), "")
    return "" if one == other else path
