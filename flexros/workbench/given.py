"""What the functions of the workbench accept: a log or its path, a robot or its name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from flexros.effects import RobotWithEffects
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.robot import Robot

if TYPE_CHECKING:
    from flexros.workbench.runs import Run

GivenLog: TypeAlias = "Log | Run | str | Path"
"""A log, a run, or the path of a rosbag2 folder or of an .mcap file."""
GivenModel: TypeAlias = "Robot | RobotWithEffects | str | Path"
"""A robot, or the name of a built-in one, or the path of a robot file or of a patch."""


def log_of(given: GivenLog, namespace: str | None = None) -> Log:
    """Return a log, read where a path was given.

    Args:
        given: A log, a run, or a path.
        namespace: Namespace of the topics, where a file holds several.

    Raises:
        InputError: There is no such log, or it cannot be read.
    """
    if isinstance(given, Log):
        return given
    if isinstance(given, (str, Path)):
        return read_log(given, namespace)
    return given.log


def name_of(given: GivenLog, number: int = 1) -> str:
    """Return the name of a log for messages: its folder, its run, or "log 1"."""
    if isinstance(given, (str, Path)):
        return Path(given).name
    return f"log {number}" if isinstance(given, Log) else given.name


def model_of(given: GivenModel) -> RobotWithEffects:
    """Return a robot with its known effects, loaded where a name or path was given.

    Raises:
        InputError: It cannot be loaded.
    """
    if isinstance(given, RobotWithEffects):
        return given
    return RobotWithEffects(given, ()) if isinstance(given, Robot) else load_model(given)


def robot_of(given: GivenModel) -> Robot:
    """Return a robot without the laws of its effects, for linear analysis.

    Raises:
        InputError: It cannot be loaded.
    """
    return model_of(given).robot


def reference_of(given: GivenModel) -> str:
    """Return name or path under which a model can be loaded again, as a file that refers to it must.

    Raises:
        InputError: The model was made in this process and has no file.
    """
    if isinstance(given, (str, Path)):
        return str(given)
    robot = given if isinstance(given, Robot) else given.robot
    if isinstance(given, Robot) and _is_loaded_again(robot):
        return robot.source
    raise InputError(
        f"the model {robot.name} was changed in this process and no file holds it, but a patch refers to the file of "
        "its robot; give the name or the path of the model instead of the object",
        "model",
    )


def _is_loaded_again(robot: Robot) -> bool:
    try:
        return load_model(robot.source).robot.model_hash == robot.model_hash
    except InputError:
        return False
