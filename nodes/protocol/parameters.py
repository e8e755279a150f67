"""Node parameters as data: type, default, bounds, unit and description from `msgs_config/<node>.yaml`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, TypeAlias

from pydantic import Field, model_validator

from flexros.config.location import data_folder
from flexros.config.settings import Settings, validate
from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw

Value: TypeAlias = bool | int | float | str

_TYPES: dict[str, tuple[type, ...]] = {"bool": (bool,), "int": (int,), "double": (float, int), "string": (str,)}
_ARTICLES = {"bool": "true or false", "int": "a whole number", "double": "a number", "string": "a text"}

REPLACES = {"identification": "feedforward"}
"""Nodes that replace another one and inherit its parameters."""

LARGEST_GAIN = 1e12
"""Largest gain that can be set at run time, in SI units, chosen: more is taken for a mistake."""


class ParameterSpecification(Settings):
    """One row of a parameter file."""

    type: Literal["bool", "int", "double", "string"] = Field(description="type of the value [name]")
    default: Value = Field(description="default value, in `unit`")
    bounds: tuple[float, float] | None = Field(default=None, description="lowest and highest allowed value, in `unit`")
    allowed: tuple[str, ...] | None = Field(default=None, description="allowed texts")
    unit: str = Field(description="unit of the value, empty where it has none")
    description: str = Field(min_length=1, description="effect of the parameter")
    read_only: bool = Field(default=True, description="whether it is constant while the node runs")

    @model_validator(mode="after")
    def _default_is_allowed(self) -> ParameterSpecification:
        if problem := self.problem(self.default):
            raise ValueError(f"the default {problem}")
        return self

    def problem(self, value: object) -> str:
        """Return what is wrong with a value, "is ..., allowed is ..."; empty if it is allowed."""
        unit = f" {self.unit}" if self.unit else ""
        if not isinstance(value, _TYPES[self.type]) or (isinstance(value, bool) and self.type != "bool"):
            return f"is {value!r}, allowed is {_ARTICLES[self.type]}{self._range()}"
        if isinstance(value, float) and not math.isfinite(value):
            return f"is {value}, allowed is a finite number{self._range()}"
        if self.bounds and not self.bounds[0] <= value <= self.bounds[1]:  # type: ignore[operator]
            return f"is {value:g}{unit}, allowed is a number{self._range()}"
        if self.allowed is not None and value not in self.allowed:
            return f"is '{value}', allowed are {', '.join(self.allowed)}"
        return ""

    def _range(self) -> str:
        if self.bounds is None:
            return ""
        unit = f" {self.unit}" if self.unit else ""
        return f" from {self.bounds[0]:g} to {self.bounds[1]:g}{unit}"


def read_parameters(path: Path) -> dict[str, ParameterSpecification]:
    """Read a parameter file.

    Args:
        path: A file like `msgs_config/plant.yaml`.

    Returns:
        Specifications by parameter name.

    Raises:
        InputError: The file cannot be read or a row is invalid.
    """
    rows = read_yaml(path)
    for name, row in rows.items():
        if not isinstance(row, dict):
            raise InputError(f"{path}, key {name}: allowed is a mapping of keys; correct the file")
    return {name: validate(ParameterSpecification, row, f"{path}, parameter {name}") for name, row in rows.items()}


def node_parameters(node: str) -> dict[str, ParameterSpecification]:
    """Return the parameters of a node: those of all nodes, of the node it replaces, and its own.

    Args:
        node: "plant", "controller", "feedforward", "identification" or "recorder".

    Returns:
        Specifications by parameter name.
    """
    folder = data_folder("msgs_config")
    files = ("all_nodes", REPLACES.get(node), node)
    return {name: row for file in files if file for name, row in read_parameters(folder / f"{file}.yaml").items()}


def gain_parameters(
    law: AbstractControlLaw, names: Sequence[str], gains: FloatArray
) -> dict[str, ParameterSpecification]:
    """Return the parameters for the gains of a control law; infinite limits have none.

    Args:
        law: The control law.
        names: Names of the gains.
        gains: Gains of the scenario, in SI units, shape (n_gains,).

    Returns:
        Specifications by parameter name; the values may change while the node runs.
    """
    return {
        name: ParameterSpecification(
            type="double",
            default=float(gain),
            bounds=(max(law.lowest_gain, -LARGEST_GAIN), LARGEST_GAIN),
            unit="",
            description=f"Gain {name} of the control law {law.kind}, in SI units.",
            read_only=False,
        )
        for name, gain in zip(names, gains.tolist(), strict=True)
        if math.isfinite(gain)
    }


def check_value(node: str, name: str, value: object, specifications: Mapping[str, ParameterSpecification]) -> Value:
    """Check a value and convert it to its type.

    Args:
        node: Name of the node, for error messages.
        name: Name of the parameter.
        value: Value given.
        specifications: All parameters of the node.

    Returns:
        The value; an integer for a double becomes a double.

    Raises:
        InputError: The parameter is unknown, or the value is not allowed.
    """
    if name not in specifications:
        raise unknown_name(f"parameter of node {node}", name, specifications)
    specification = specifications[name]
    if problem := specification.problem(value):
        raise InputError(f"parameter {name} of node {node} {problem}; {specification.description}")
    return float(value) if specification.type == "double" else value  # type: ignore[arg-type, return-value]
