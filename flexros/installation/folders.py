"""Folders that FlexROS writes: cache of machine code, home, temporary files."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.compile.object_cache import VARIABLE, cache_folder
from flexros.installation.finding import Finding

if TYPE_CHECKING:
    from collections.abc import Mapping

LEAST_FREE = 1_000_000_000
"""Free space below which logs of long runs do not fit [bytes] (chosen)."""


def check_cache() -> Finding:
    """Check the folder in which compiled models are kept."""
    folder, usable = cache_folder()
    facts = {"folder": None if folder is None else str(folder), "usable": usable}
    if usable:
        return Finding("cache", "ok", f"compiled models are kept in {folder}", facts=facts)
    if folder is None:
        text = f"compiled models are not kept: {VARIABLE} is off, or the user has no home"
    else:
        text = f"{folder} cannot be used: it must belong to this user and be writable by nobody else"
    return Finding("cache", "limited", f"{text}; each process compiles again", f"set {VARIABLE} to a folder", facts)


def check_home(environment: Mapping[str, str]) -> Finding:
    """Check the home folder, into which ROS 2 writes its logs.

    Args:
        environment: Environment variables.
    """
    home = environment.get("HOME", "")
    facts = {"folder": home}
    if home and _writable(Path(home)):
        return Finding("home", "ok", f"{home} is writable", facts=facts)
    text = f"HOME is '{home}', which cannot be written" if home else "HOME is not set"
    return Finding("home", "limited", f"{text}: logs of ROS 2 go to temporary files", "set HOME or ROS_LOG_DIR", facts)


def check_temporary() -> Finding:
    """Check the folder of temporary files, which runs need."""
    try:
        folder = Path(tempfile.gettempdir())
    except OSError as error:
        return Finding("temporary files", "broken", str(error), "set TMPDIR to a folder that can be written")
    free = shutil.disk_usage(folder).free
    facts = {"folder": str(folder), "free_bytes": free}
    text = f"{folder}, {free / 1e9:.3g} GB free"
    if not _writable(folder):
        return Finding(
            "temporary files", "broken", f"{text}, not writable", "set TMPDIR to a folder that can be", facts
        )
    if free < LEAST_FREE:
        return Finding("temporary files", "limited", text, "free some space, or set TMPDIR to another disk", facts)
    return Finding("temporary files", "ok", text, facts=facts)


def _writable(folder: Path) -> bool:
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
