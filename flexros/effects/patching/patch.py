"""Patch of a robot: effects with fitted parameters in addition to a robot file, the content of `patch.yaml`."""

from __future__ import annotations

import io
import os
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field, field_validator, model_validator
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.config.settings import Settings, validate
from flexros.effects.kinds.base import PlacedEffect, effects
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SYMMETRY, LEAST_EIGENVALUE = 1e-6, -1e-6
"""Round-off accepted in a covariance from a file, relative to the standard deviations (chosen)."""


class PatchedValue(Settings):
    """A parameter value of an effect; in YAML also the plain value."""

    value: bool | float | str = Field(description="value in the SI unit of the parameter")
    std: float | None = Field(default=None, ge=0.0, description="its standard deviation, in the same unit")
    unit: str = Field(default="", description="the unit, for the reader")

    @model_validator(mode="before")
    @classmethod
    def _from_plain(cls, given: Any) -> Any:
        return given if isinstance(given, (dict, PatchedValue)) else {"value": given}


class PatchedEffect(Settings):
    """An effect at a location."""

    effect: str = Field(description="name of the effect")
    location: str = Field(description="joint, spring, body, 'tool', 'base' or 'all'")
    parameters: dict[str, PatchedValue] = Field(min_length=1, description="its parameters; the others keep defaults")


class Covariance(Settings):
    """Covariance of the fitted parameters."""

    names: tuple[str, ...] = Field(description="EFFECT@LOCATION.PARAMETER of each row")
    matrix: tuple[tuple[float, ...], ...] = Field(description="covariance, in the units of the parameters")

    @field_validator("matrix")
    @classmethod
    def _possible(cls, matrix: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        n = len(matrix)
        if not n or {len(row) for row in matrix} != {n}:
            raise ValueError(f"has {n} rows of lengths {[len(row) for row in matrix]}, but must be square; correct it")
        values = np.array(matrix)
        if np.any(values.diagonal() <= 0):
            at = int(np.argmax(values.diagonal() <= 0))
            raise ValueError(f"has the variance {matrix[at][at]:g} in row {at}, but variances must be above zero")
        deviations = np.sqrt(values.diagonal())
        correlation = values / np.outer(deviations, deviations)
        if np.abs(correlation - correlation.T).max() > SYMMETRY:
            raise ValueError("is not symmetric, but a covariance must be; correct it")
        least = float(np.linalg.eigvalsh(correlation).min())
        if least < LEAST_EIGENVALUE:
            raise ValueError(
                f"is not positive semidefinite (its correlations have the eigenvalue {least:.3g}), but a covariance "
                "must be; correct it or leave it out"
            )
        return matrix

    @model_validator(mode="after")
    def _named(self) -> Covariance:
        if len(self.names) != len(self.matrix):
            raise ValueError(f"the covariance has {len(self.names)} names for {len(self.matrix)} rows; name each row")
        return self


class Patch(Settings):
    """Effects of a robot: the content of `patch.yaml`."""

    robot: str = Field(description="built-in robot, or path of a robot file or of another patch, relative to this file")
    robot_hash: str = Field(
        default="", description="fingerprint of that robot when the patch was made; default: not checked"
    )
    source: str = Field(default="", description="origin of the patch")
    effects: tuple[PatchedEffect, ...] = Field(description="effects, in the order in which they are applied")
    covariance: Covariance | None = Field(default=None, description="covariance of the fitted parameters")

    @model_validator(mode="after")
    def _covariance_of_own_numbers(self) -> Patch:
        own = {f"{name}.{key}" for name, effect in zip(self.names, self.effects) for key in effect.parameters}
        for name in () if self.covariance is None else self.covariance.names:
            if name not in own:
                raise ValueError(
                    f"covariance.names holds '{name}', but the effects of the patch have {', '.join(sorted(own))}; "
                    "name numbers of the patch"
                )
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """Effects with locations, e.g. "coulomb_friction@motor_1"; a second one of the same kind ends in "#2"."""
        return numbered(f"{entry.effect}@{entry.location}" for entry in self.effects)

    def placed(self, source: str) -> tuple[PlacedEffect, ...]:
        """Return the effects at their locations, in the order of the file; locations are checked on a robot.

        Args:
            source: The file, for error messages.

        Raises:
            InputError: Unknown effect or parameter, or a value out of bounds.
        """
        made = []
        for index, (name, entry) in enumerate(zip(self.names, self.effects)):
            key = f"{source}, key effects[{index}]"
            if entry.effect not in effects():
                raise unknown_name("effect", entry.effect, effects(), key)
            values = {parameter: given.value for parameter, given in entry.parameters.items()}
            made.append(PlacedEffect(validate(effects()[entry.effect], values, f"{key} ({name})"), entry.location))
        return tuple(made)

    def text(self) -> str:
        """Return the content of the file."""
        writer, text = YAML(), io.StringIO()
        writer.width = 1000  # a parameter is one line
        writer.indent(mapping=2, sequence=4, offset=2)
        writer.dump(_laid_out(self.model_dump(mode="json", exclude_none=True, exclude_defaults=True)), text)
        return text.getvalue()


def numbered(names: Iterable[str]) -> tuple[str, ...]:
    """Make names unique: a second equal name ends in "#2", as for laws on a robot."""
    alike: Counter[str] = Counter()
    result = []
    for name in names:
        alike[name] += 1
        result.append(name if alike[name] == 1 else f"{name}#{alike[name]}")
    return tuple(result)


def is_patch(data: Mapping[str, Any]) -> bool:
    """Return whether the content of a YAML file is a patch, not a robot file."""
    return "robot" in data or "effects" in data


def named_robot(name: str, folder: Path) -> str:
    """Resolve a robot named in a file: a path is relative to the folder of the file; else a built-in robot."""
    return str(folder / name) if Path(name).suffix in (".yaml", ".yml") else name


def name_from(given: str, folder: Path) -> str:
    """Return the name by which a file in a folder refers to a robot: the built-in name, or the relative path."""
    if Path(given).suffix not in (".yaml", ".yml"):
        return given
    return Path(os.path.relpath(Path(given).resolve(), folder.resolve())).as_posix()


def _laid_out(node: Any) -> Any:
    """Put values with unit and rows of a matrix on one line each."""
    if isinstance(node, dict):
        block = CommentedMap((key, _laid_out(value)) for key, value in node.items())
        if "value" in node:
            block.fa.set_flow_style()
        return block
    if isinstance(node, list):
        row = CommentedSeq(_laid_out(value) for value in node)
        if not any(isinstance(value, (dict, list)) for value in node):
            row.fa.set_flow_style()
        return row
    return node
