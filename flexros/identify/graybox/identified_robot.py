"""The identified robot as a robot file: the same robot with new values, their source and their tolerance."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.robot.robot import robot_from_data
from flexros.whole_file import write_result

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.fit import Fit
    from flexros.robot.parameters import Parameter
    from flexros.robot.robot import Robot

LARGEST_TOLERANCE = 10.0
"""Largest relative standard deviation that is written: beyond it nothing is known of the value (chosen)."""


def identified_data(robot: Robot, fit: Fit, covariance: ParameterCovariance, origin: str = "") -> dict[str, Any]:
    """Put fitted values into the content of a robot file.

    Args:
        robot: The robot that was identified.
        fit: Fitted values.
        covariance: Their covariance, from which the tolerances come.
        origin: What else the source of the values says, e.g. the name of the log.

    Returns:
        Content of a robot file: what the robot's own file sets, with value, source and tolerance of every fitted
        parameter replaced. A tolerance is one standard deviation relative to the value; a value of zero has none.

    Raises:
        InputError: The robot with the fitted values is not physical.
    """
    source = f"identified by FlexROS, {fit.estimator} with {fit.weights} weights{', ' + origin if origin else ''}"
    changed = robot.with_values(dict(zip(fit.names, fit.values.tolist(), strict=True)), source)
    data: dict[str, Any] = robot.spec.model_dump(mode="json", exclude_unset=True)
    full = changed.spec.model_dump(mode="json")
    for name, relative in zip(fit.names, covariance.relative, strict=True):
        _place(data, full, robot.parameters[name], source, float(relative))
    plain: dict[str, Any] = _without_empty(data)
    return plain


def identified_robot(robot: Robot, fit: Fit, covariance: ParameterCovariance, origin: str = "") -> Robot:
    """Return the robot with fitted values, their source and tolerance; arguments as for `identified_data`."""
    return robot_from_data(identified_data(robot, fit, covariance, origin), f"identified {robot.name}")


def identified_yaml(robot: Robot, fit: Fit, covariance: ParameterCovariance, origin: str = "") -> str:
    """Return the text of the identified robot's file; arguments as for `identified_data`."""
    data = identified_data(robot, fit, covariance, origin)
    writer, text = YAML(), io.StringIO()
    writer.width = 1000  # a quantity is one line
    writer.indent(mapping=2, sequence=4, offset=2)
    writer.dump(_laid_out(data), text)
    return text.getvalue()


def write_identified_robot(
    path: Path, robot: Robot, fit: Fit, covariance: ParameterCovariance, origin: str = ""
) -> None:
    """Write the identified robot as a robot file, whole or not at all.

    Args:
        path: File to write.
        robot: The robot that was identified.
        fit: Fitted values.
        covariance: Their covariance.
        origin: What else the source of the values says.

    Raises:
        InputError: The file cannot be written, or the robot with the fitted values is not physical.
    """
    write_result(path, identified_yaml(robot, fit, covariance, origin), "identified robot")


def _place(data: Any, full: Any, parameter: Parameter, source: str, relative: float) -> None:
    """Copy one parameter with what belongs to it from the full content into the content that a file sets."""
    *way, last = _path_of_quantity(parameter)
    here, there = data, full
    for step in way:
        here = here.setdefault(step, {}) if isinstance(step, str) else here[step]
        there = there[step]
    target = entry = dict(there[last])
    if last == "spring":
        law = next(word for word in ("stiffness", "piecewise_linear", "cubic") if entry[word] is not None)
        target = dict(entry[law])
        entry = target if law == "stiffness" else {law: target}
    if "unit" in target:
        target["unit"] = parameter.unit
    before = here.get(last, {})
    known = before.get("tolerance") if before.get("source") == source else None  # another component of the same vector
    target["source"] = source
    target["tolerance"] = known
    if np.isfinite(relative):
        target["tolerance"] = max(float(f"{min(relative, LARGEST_TOLERANCE):.4g}"), known or 0.0)
    here[last] = entry


def _path_of_quantity(parameter: Parameter) -> tuple[str | int, ...]:
    """Keys that lead to the quantity that holds a parameter: for a component of a vector, to the vector."""
    component = isinstance(parameter.path[-1], int)
    return parameter.path[:-1] if component else parameter.path


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
