"""Measured tool positions at rest, with motor positions and load."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray, IntArray
    from flexros.robot import Robot

LOAD = "load"
TOOL = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class PoseRecord:
    """Poses at rest.

    Attributes:
        motor_position: Motor positions [rad or m], shape (n, M).
        load: Mass at the tool point in addition to that of the robot file [kg], shape (n,).
        tool: Measured tool point in the frame of the tracker [m], shape (n, 3).
    """

    motor_position: FloatArray
    load: FloatArray
    tool: FloatArray

    def __len__(self) -> int:
        return len(self.load)

    def rows(self, chosen: IntArray) -> PoseRecord:
        """Return some of the poses."""
        return PoseRecord(self.motor_position[chosen], self.load[chosen], self.tool[chosen])


def read_poses(path: Path, robot: Robot) -> PoseRecord:
    """Read poses from a CSV file with columns named as the motors, x, y, z [m] and, if loads differ, load [kg].

    Raises:
        InputError: A column is missing, or an entry is no finite number.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"poses cannot be read from {path}: {error}; give a CSV file") from error
    needed = (*robot.joint_names, *TOOL)
    if not rows:
        raise InputError(f"{path} has no pose; give a line of names ({', '.join(needed)}) and a line per pose")
    missing = [name for name in needed if name not in rows[0]]
    if missing:
        raise InputError(
            f"{path} lacks the columns {', '.join(missing)}; required are {', '.join(needed)}, and {LOAD} [kg] where "
            "loads differ"
        )
    values = np.array(
        [[_number(row.get(name) or ("0" if name == LOAD else ""), path, line, name) for name in (*needed, LOAD)]
         for line, row in enumerate(rows, start=2)]
    )  # fmt: skip
    m = robot.n_motors
    return PoseRecord(values[:, :m], values[:, -1], values[:, m : m + 3])


def poses_text(robot: Robot, record: PoseRecord) -> str:
    """Return the poses as the text of a CSV file."""
    lines = [",".join((*robot.joint_names, LOAD, *TOOL))]
    for motors, load, tool in zip(record.motor_position, record.load, record.tool, strict=True):
        lines.append(",".join(f"{value:.9g}" for value in (*motors, load, *tool)))
    return "\n".join(lines) + "\n"


def _number(text: str, path: Path, line: int, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InputError(f"{path}, line {line}, column {name} is '{text}', but must be a finite number; correct it")
    return value
