"""Folder of the text logs of ROS 2, which refuses to start where it cannot write them: service accounts, containers."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.errors import RunError

if TYPE_CHECKING:
    from collections.abc import Mapping

FOLDER_VARIABLE = "ROS_LOG_DIR"


def ros_log_settings(given: Mapping[str, str]) -> dict[str, str]:
    """Return the environment settings that give ROS 2 a folder for its logs where its own cannot be written.

    ROS 2 takes ROS_LOG_DIR, else log in ROS_HOME, else .ros/log in HOME; without one of them no node starts.

    Args:
        given: Environment variables of the user.

    Returns:
        Empty where the folder of the user can be written; else a folder for temporary files.

    Raises:
        RunError: Temporary files cannot be written either.
    """
    if any(given.get(name) and _writable(_folder(name, given[name])) for name in _first_of(given)):
        return {}
    folder = Path(tempfile.gettempdir()) / f"flexros_ros_log_{os.getuid() if hasattr(os, 'getuid') else 0}"
    if not _writable(folder):
        raise RunError(
            f"ROS 2 can write its logs neither into HOME ('{given.get('HOME', '')}') nor into {folder}; set "
            f"{FOLDER_VARIABLE} to a folder that can be written"
        )
    return {FOLDER_VARIABLE: str(folder)}


def _first_of(given: Mapping[str, str]) -> list[str]:
    """Return the variable that decides: the first that is set."""
    return [name for name in (FOLDER_VARIABLE, "ROS_HOME", "HOME") if given.get(name)][:1]


def _folder(variable: str, value: str) -> Path:
    below = {FOLDER_VARIABLE: "", "ROS_HOME": "log", "HOME": ".ros/log"}
    return Path(value) / below[variable]


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
