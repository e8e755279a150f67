"""Mapping files: quantity, joint and unit of the columns of a foreign log."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pydantic import Field, model_validator

from flexros.config.settings import Settings, validate
from flexros.config.yaml_file import read_yaml
from flexros.errors import unknown_name
from flexros.logs.foreign.quantities import QUANTITIES, TIME_UNITS, UNITS, units_of

if TYPE_CHECKING:
    from collections.abc import Iterable

MAPPINGS = Path(__file__).parents[1] / "mappings"
"""Folder of the built-in mapping files."""


_PER = re.compile(r"[^/]+(/s2?)?/[^/]+")
"""A mechanical unit per another unit."""


class Scale(Settings):
    """Conversion of a non-mechanical unit to a mechanical one, e.g. 35.15 N/V or 6.28e-5 rad/count."""

    value: float = Field(description="of the unit below; not zero")
    unit: str = Field(description="mechanical unit per unit of the column, e.g. N/V")

    @model_validator(mode="after")
    def _converts(self) -> Scale:
        if not _PER.fullmatch(self.unit):
            raise ValueError(
                f"unit is '{self.unit}', but must be a mechanical unit per unit of the column, as Nm/A, rad/count or "
                "rad/s/V"
            )
        if self.value == 0:
            raise ValueError("a scale of 0 makes the column zero; give another value")
        return self

    @property
    def target(self) -> str:
        """Mechanical unit after the scale."""
        return self.unit.rpartition("/")[0]

    @property
    def origin(self) -> str:
        """Unit of the column."""
        return self.unit.rpartition("/")[2]


class Clock(Settings):
    """Time of the rows: a column, or a rate."""

    column: str = Field("", description="name of the time column")
    unit: str = Field("s", description="unit of the time column: s, ms, us or ns")
    file: str = Field(
        "",
        description="name of the files with this clock, with wildcards * and ?; all if left out. Or of a file of times "
        "alone, whose rows are those of files without another clock",
    )
    offset: float = Field(0.0, description="added to the times [s], for files whose clocks start at different times")
    rate: float | None = Field(None, gt=0, le=1e6, description="rows per second [Hz], if there is no time column")

    @model_validator(mode="after")
    def _one_of_both(self) -> Clock:
        if bool(self.column) == (self.rate is not None):
            raise ValueError("give either 'column' (the name of the time column) or 'rate' (rows per second)")
        if self.unit not in TIME_UNITS:
            raise ValueError(f"unit is '{self.unit}', but allowed are {', '.join(TIME_UNITS)}")
        return self


class MappedColumn(Settings):
    """One column: its quantity, and the conversion of its numbers to SI values in the coordinate of the robot file.

    value = sign * gear * (scale * column in SI) + offset, where gear is 1 / gear_ratio for positions and velocities and
    gear_ratio for torques: columns measured on the motor side are converted to the arm side of the gear.
    """

    column: str = Field(
        "",
        description="name in the file; name[k] is signal k, from 0, of a matrix, whose longer side are the samples, or "
        "of a list in a cell, [k] that of a table without names",
    )
    sum: dict[str, float] = Field(
        default_factory=dict,
        description="instead of 'column': factors of several columns of one file, which are added, as for joints of "
        "a coupled wrist",
    )
    quantity: str = Field(description="quantity of the column")
    joint: str = Field("motor_1", pattern=r"^motor_[1-9][0-9]*$", description="motor of the column")
    axis: Literal["x", "y", "z"] | None = Field(None, description="axis of a quantity of the tool, in its own frame")
    unit: str = Field(min_length=1, description="unit of the numbers in the file")
    scale: Scale | None = Field(None, description="needed for a unit like V, A or count")
    sign: Literal[1, -1] = Field(1, description="-1 if the file has the opposite sign of the robot file")
    gear_ratio: float = Field(1.0, gt=0, description="motor turns per arm turn, if the column is on the motor side")
    offset: float = Field(0.0, description="added after all factors [SI unit]")
    period: float | None = Field(
        None,
        gt=0,
        description="range after which an encoder begins again, in the unit of the file, as 360 for deg: steps of more "
        "than half of it are turns",
    )
    time_offset: float = Field(0.0, ge=-10, le=10, description="time of the quantity minus time of its row [s]")
    time: Clock | None = Field(None, description="clock of this column alone, if it is not that of its file")
    file: str = Field("", description="name of its file, with wildcards * and ?, if several files have such a column")
    optional: bool = Field(False, description="may be missing")

    @model_validator(mode="after")
    def _unit_fits(self) -> MappedColumn:
        if self.quantity not in QUANTITIES:
            raise ValueError(f"'{self.quantity}' is not a known quantity; allowed are {', '.join(QUANTITIES)}")
        if bool(self.column) == bool(self.sum):
            raise ValueError(f"quantity {self.quantity}: give either 'column' or 'sum' (factors of several columns)")
        kind, of_tool = QUANTITIES[self.quantity].kind, QUANTITIES[self.quantity].of_tool
        column = f"column '{self.label}', quantity {self.quantity}:"
        if of_tool != (self.axis is not None):
            raise ValueError(f"{column} {'add' if of_tool else 'leave out'} the key 'axis' (x, y or z of the tool)")
        if self.period is not None and kind != "position":
            raise ValueError(f"{column} leave out the key 'period', which is of positions alone")
        if self.scale is not None and self.scale.origin != self.unit:
            raise ValueError(
                f"{column} the unit is '{self.unit}', but the scale is per '{self.scale.origin}'; make them the same"
            )
        target = self.target_unit
        if target not in units_of(kind):
            hint = "" if self.scale else f"; another unit needs a scale, e.g. {{value: 2, unit: {units_of(kind)[0]}/V}}"
            raise ValueError(f"{column} unit '{target}', but allowed are {', '.join(units_of(kind))}{hint}")
        return self

    @property
    def factors(self) -> dict[str, float]:
        """Factors of the columns that are added."""
        return self.sum or {self.column: 1.0}

    @property
    def label(self) -> str:
        """Name of the column, or of all, for messages."""
        return self.column or " + ".join(self.sum)

    @property
    def component(self) -> str:
        """Joint of the quantity, or axis of the tool."""
        return self.axis or self.joint

    @property
    def target_unit(self) -> str:
        """Mechanical unit that the numbers have after the scale."""
        return self.scale.target if self.scale else self.unit

    @property
    def rotary(self) -> bool:
        """Whether the unit is that of a rotation."""
        return UNITS[self.target_unit].rotary

    @property
    def factor(self) -> float:
        """Factor of the numbers of the column."""
        gear = self.gear_ratio if QUANTITIES[self.quantity].kind == "torque" else 1 / self.gear_ratio
        scale = self.scale.value if self.scale else 1.0
        return self.sign * UNITS[self.target_unit].factor * scale * gear


class LogMapping(Settings):
    """A mapping file."""

    name: str = Field(min_length=1)
    description: str = ""
    source: str = Field("", description="where the data come from")
    time: Clock | tuple[Clock, ...] | None = Field(
        None,
        description="clock of the rows, or a list of clocks of different files, of which the first that fits counts; "
        "left out for ROS 2 bags, whose messages have times",
    )
    columns: tuple[MappedColumn, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _consistent(self) -> LogMapping:
        seen: set[str] = set()
        fields: set[tuple[str, str, str]] = set()
        rotary: dict[str, MappedColumn] = {}
        for entry in self.columns:
            name = f"{entry.quantity} of {entry.component}"
            field = QUANTITIES[entry.quantity].field, QUANTITIES[entry.quantity].topic, entry.component
            if name in seen or field in fields:
                raise ValueError(f"{name} is mapped twice; leave one column out")
            seen.add(name)
            fields.add(field)
            if QUANTITIES[entry.quantity].of_tool:
                continue
            earlier = rotary.setdefault(entry.joint, entry)
            if earlier.rotary != entry.rotary:
                turning, sliding = (earlier, entry) if earlier.rotary else (entry, earlier)
                raise ValueError(
                    f"{entry.joint} is rotary by column '{turning.label}' but linear by column '{sliding.label}'; "
                    "correct a unit"
                )
        joints = {entry.joint for entry in self.columns if not QUANTITIES[entry.quantity].of_tool}
        for joint in sorted(joints):
            if f"position of {joint}" not in seen:
                raise ValueError(f"the quantity position of {joint} is missing; map its column")
        return self


def clock_of(mapping: LogMapping, entry: MappedColumn, file: str, alone: Iterable[str] = ()) -> Clock | None:
    """Return the clock of a column: its own, or the first of the mapping that fits its file; None without one.

    Args:
        mapping: The mapping.
        entry: The column.
        file: Name of its file.
        alone: Names of files that hold no column of the mapping, whose times count where no clock fits the file.
    """
    if entry.time is not None:
        return entry.time
    clocks = mapping.time if isinstance(mapping.time, tuple) else () if mapping.time is None else (mapping.time,)
    fitting = (clock for name in (file, *alone) for clock in clocks if not clock.file or fnmatch(name, clock.file))
    return next(fitting, None)


def mapping_names() -> tuple[str, ...]:
    """List the built-in mapping files."""
    return tuple(sorted(path.stem for path in MAPPINGS.glob("*.yaml")))


def load_mapping(name_or_path: str | Path) -> LogMapping:
    """Load a built-in mapping or a mapping file.

    Args:
        name_or_path: Built-in name such as "emps", or path of a YAML file.

    Returns:
        The mapping.

    Raises:
        InputError: Unknown name, unreadable file, unknown key, quantity or unit, or a value that is not allowed.
    """
    path = MAPPINGS / f"{name_or_path}.yaml"
    if str(name_or_path) not in mapping_names():
        path = Path(name_or_path)
        if path.suffix not in (".yaml", ".yml"):
            raise unknown_name("mapping", str(name_or_path), mapping_names(), other="or the path of a .yaml file")
    source = f"mapping {name_or_path}" if path.parent == MAPPINGS else str(path)
    return validate(LogMapping, {"name": path.stem, **read_yaml(path)}, source)
