"""A robot file with identified values: the same robot, with their source and tolerance."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot.parameters import Parameter
    from flexros.robot.robot import Robot

LARGEST_TOLERANCE = 10.0
"""Largest relative standard deviation that is written: beyond it nothing is known of the value (chosen)."""


@dataclass(frozen=True)
class IdentifiedValue:
    """One identified number.

    Attributes:
        value: Value in the SI unit.
        relative: Standard deviation, relative to the value.
    """

    value: float
    relative: float


def identified_data(robot: Robot, values: Mapping[str, IdentifiedValue], source: str) -> dict[str, Any]:
    """Put new values into the content of a robot file.

    Args:
        robot: The robot that was identified.
        values: New values by parameter name.
        source: Origin of the values, written to the file with each of them.

    Returns:
        Content of a robot file: what the robot's own file sets, with value, source and tolerance of every identified
        parameter replaced. A tolerance is one standard deviation relative to the value; of a vector by their lengths.

    Raises:
        InputError: The robot with the values is not physical.
    """
    changed = robot.with_values({name: entry.value for name, entry in values.items()}, source)
    data: dict[str, Any] = robot.spec.model_dump(mode="json", exclude_unset=True)
    full = changed.spec.model_dump(mode="json")
    quantities: dict[tuple[str | int, ...], list[str]] = {}
    for name in values:
        quantities.setdefault(_path_of_quantity(robot.parameters[name]), []).append(name)
    for path, names in quantities.items():
        known = {"unit": robot.parameters[names[0]].unit, "source": source}
        _place(data, full, path, {**known, "tolerance": _tolerance([values[name] for name in names])})
    plain: dict[str, Any] = _without_empty(data)
    return plain


def identified_file(robot: Robot, values: Mapping[str, IdentifiedValue], source: str) -> str:
    """Return the text of a robot file with new values; arguments and errors as for `identified_data`."""
    data = identified_data(robot, values, source)
    robot_from_data(data, source)
    writer, text = YAML(), io.StringIO()
    writer.width = 1000  # a quantity is one line
    writer.indent(mapping=2, sequence=4, offset=2)
    writer.dump(_laid_out(data), text)
    return text.getvalue()


def _path_of_quantity(parameter: Parameter) -> tuple[str | int, ...]:
    """Keys that lead to the quantity that holds a parameter: for a component of a vector, to the vector."""
    return parameter.path[:-1] if isinstance(parameter.path[-1], int) else parameter.path


def _tolerance(entries: list[IdentifiedValue]) -> float:
    """Relative standard deviation of a number, or of a vector by the lengths of deviation and value."""
    if len(entries) == 1:
        relative = entries[0].relative
    else:
        deviation = np.linalg.norm([entry.relative * entry.value for entry in entries])
        relative = float(deviation / max(np.linalg.norm([entry.value for entry in entries]), np.finfo(float).tiny))
    return float(f"{min(relative, LARGEST_TOLERANCE):.4g}") if np.isfinite(relative) else LARGEST_TOLERANCE


def _place(data: Any, full: Any, path: tuple[str | int, ...], known: dict[str, Any]) -> None:
    """Copy one quantity from the full content into the content that a file sets, with its known attributes."""
    *way, last = path
    here, complete = data, full
    for step in way:
        here = here.setdefault(step, {}) if isinstance(step, str) else here[step]
        complete = complete[step]
    target = entry = dict(complete[last])
    if last == "spring":
        law = next(word for word in ("stiffness", "piecewise_linear", "cubic") if entry[word] is not None)
        target = dict(entry[law])
        entry = target if law == "stiffness" else {law: target}
    target.update({key: value for key, value in known.items() if key in target})
    here[last] = entry


def _without_empty(node: Any) -> Any:
    """Drop what says nothing: empty texts and keys without a value."""
    if isinstance(node, dict):
        return {key: _without_empty(value) for key, value in node.items() if value is not None and value != ""}
    return [_without_empty(value) for value in node] if isinstance(node, list) else node


def _laid_out(node: Any) -> Any:
    """Set quantities and other small mappings in one line each."""
    if isinstance(node, dict):
        block = CommentedMap((key, _laid_out(value)) for key, value in node.items())
        if not any(isinstance(value, (dict, list)) and key != "value" for key, value in node.items()):
            block.fa.set_flow_style()
        return block
    if isinstance(node, list):
        row = CommentedSeq(_laid_out(value) for value in node)
        if not any(isinstance(value, (dict, list, str)) for value in node):
            row.fa.set_flow_style()
        return row
    return node
