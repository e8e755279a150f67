"""Commands with file systems of their own, where the system permits it: nobody else's files are in the way."""

from __future__ import annotations

import shlex
import subprocess
from pathlib import Path


def with_mount(command: list[str], folder: Path, size: str) -> list[str]:
    """Return a command that runs with an empty file system of a given size at a folder, and unmounts it at its end."""
    script = f"mount -t tmpfs -o size={size} none {shlex.quote(str(folder))} && exec {shlex.join(command)}"
    return ["unshare", "--mount", "sh", "-c", script]


def mounts_are_allowed(folder: Path) -> bool:
    """Return whether this user may do that."""
    try:
        return subprocess.run(with_mount(["true"], folder, "1m"), capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False
