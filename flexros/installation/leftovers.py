"""Caches and temporary folders of FlexROS: what there is, how large, whether in use, and their removal."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexros.compile.object_cache import cache_folder

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

TEMPORARY = re.compile(
    r"flexros_((logs|truth|sensitivity|launch|tests|fuzz|browser)_)?[a-z0-9_]{8}|flexros_ros_log_\d+"
)
"""Names of our folders among the temporary files, as `tempfile` makes them: with eight random letters."""
PROCESSES = Path("/proc")
RECENT = 3600.0
"""Age of the last change below which a temporary folder counts as in use [s] (chosen)."""


@dataclass(frozen=True)
class Leftover:
    """A folder that can be removed.

    Attributes:
        path: The folder.
        what: What it holds.
        size: Size of its files [bytes].
        files: Number of its files.
        in_use: Whether a process of this user works with it, or it changed within the last hour; then it is kept.
    """

    path: Path
    what: str
    size: int
    files: int
    in_use: bool

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "path": str(self.path),
            "what": self.what,
            "bytes": self.size,
            "files": self.files,
            "in_use": self.in_use,
        }


def find_leftovers(
    temporary: Path | None = None, processes: Path = PROCESSES, now: float | None = None
) -> tuple[Leftover, ...]:
    """List the cache of compiled models and the temporary folders of FlexROS that belong to this user.

    Args:
        temporary: Folder of temporary files; default: that of the system.
        processes: Proc file system, by which it is known what is in use.
        now: Present time [s since 1970]; default: that of the system.
    """
    now = time.time() if now is None else now
    folder = Path(tempfile.gettempdir()) if temporary is None else temporary
    mentioned = tuple(_mentioned(processes))
    found = []
    cache, usable = cache_folder()
    if cache is not None and usable and any(cache.iterdir()):
        # removed objects are compiled again: a running process is not harmed
        found.append(_leftover(cache, "compiled models, made again when needed", in_use=False))
    for path in sorted(folder.glob("flexros_*")):
        if path != cache and _is_ours(path):
            used = any(str(path) in text for text in mentioned) or now - _changed(path) < RECENT
            found.append(_leftover(path, "temporary files", in_use=used))
    return tuple(found)


def remove(leftovers: Sequence[Leftover]) -> tuple[Leftover, ...]:
    """Remove folders that are not in use.

    Args:
        leftovers: The folders.

    Returns:
        Those that were removed whole.
    """
    removed = []
    for leftover in leftovers:
        if leftover.in_use:
            continue
        shutil.rmtree(leftover.path, ignore_errors=True)
        if not leftover.path.exists():
            removed.append(leftover)
    return tuple(removed)


def _leftover(path: Path, what: str, *, in_use: bool) -> Leftover:
    sizes = []
    for file in _files(path):
        with suppress(OSError):  # removed meanwhile
            sizes.append(file.lstat().st_size)
    return Leftover(path, what, sum(sizes), len(sizes), in_use)


def _changed(path: Path) -> float:
    """Return when a folder or one of its files changed last [s since 1970]."""
    times = [path.lstat().st_mtime]
    for file in _files(path):
        with suppress(OSError):
            times.append(file.lstat().st_mtime)
    return max(times)


def _files(path: Path) -> Iterator[Path]:
    for folder, _, names in os.walk(path):
        for name in names:
            file = Path(folder) / name
            if file.is_symlink() or file.exists():
                yield file


def _is_ours(path: Path) -> bool:
    """Tell our folders, which nobody else may read, from those in which a user keeps results, e.g. flexros_circle."""
    if TEMPORARY.fullmatch(path.name) is None or path.is_symlink() or not path.is_dir():
        return False
    if not hasattr(os, "geteuid"):
        return True
    about = path.lstat()
    return about.st_uid == os.geteuid() and about.st_mode & 0o077 == 0


def _mentioned(processes: Path) -> Iterator[str]:
    """List what shows that a process works with a folder: environment, command, working folder, open files."""
    for process in processes.glob("[0-9]*"):
        for name in ("environ", "cmdline"):
            with suppress(OSError):
                yield (process / name).read_text(encoding="utf-8", errors="replace")
        with suppress(OSError):
            yield str((process / "cwd").readlink())
        with suppress(OSError):
            for link in (process / "fd").iterdir():
                with suppress(OSError):
                    yield str(link.readlink())
