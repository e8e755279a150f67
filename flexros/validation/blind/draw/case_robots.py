"""Robots of the blind check: the shipped ones, and a rigid six-axis arm of its own."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.robot import load_robot

if TYPE_CHECKING:
    from flexros.robot import Robot

_OWN = Path(__file__).parents[1] / "robots"


def robot_source(name: str) -> str:
    """Return what `load_robot` takes for a robot: the path of one of the check's own files, else the name."""
    own = _OWN / f"{name}.yaml"
    return str(own) if own.exists() else name


@cache
def case_robot(name: str) -> Robot:
    """Load a robot of the blind check.

    Args:
        name: Name of a shipped robot, or of one of the check's own.

    Raises:
        InputError: There is no such robot.
    """
    return load_robot(robot_source(name))
