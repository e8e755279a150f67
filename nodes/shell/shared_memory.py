"""Shared memory that a killed process leaves behind, free of ROS."""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from time import sleep
from typing import NoReturn

try:
    import fcntl
except ImportError:  # systems without POSIX locks have no such segments either
    fcntl = None  # type: ignore[assignment]

FOLDER = Path("/dev/shm")  # noqa: S108 - where Linux keeps shared memory
PROCESSES = Path("/proc")
LOCK_SUFFIX = "_el"
_MOST_FILES = 65_536
_LOOKS, _PAUSE = 5, 0.05
"""Looks while a segment is locked that nobody maps (another cleaner tries its lock), and seconds between (chosen)."""

_NAME = re.compile(r"^(?:sem\.)?((?:fastrtps|fastdds)_[a-z0-9]+)(?:_el|_sl|_mutex)?$")


def remove_segments_without_owner(folder: Path = FOLDER, processes: Path = PROCESSES) -> list[str]:
    """Remove Fast DDS segments of this user that no process uses any more.

    A segment is in use when a process has it mapped, or holds a lock on the file `<segment>_el` beside it, which is
    how Fast DDS itself tells. Call it when the processes that used the segments are gone: a living partner would make
    them anew.

    Args:
        folder: Where segments lie.
        processes: Where the system shows its processes.

    Returns:
        Names of the removed segments.
    """
    removed: list[str] = []
    if fcntl is None or not folder.is_dir():
        return removed
    for look in range(_LOOKS):
        if look:
            sleep(_PAUSE)
        files = _files(folder)
        in_use = _mapped_names(folder, processes) if files else set()
        idle = [name for name in sorted(files) if name not in in_use]
        unused = [name for name in idle if _unlocked(folder, name)]
        for name in unused:
            for path in files[name]:
                path.unlink(missing_ok=True)
        removed += unused
        if len(unused) == len(idle):
            break
    return removed


def become_cleaner() -> NoReturn:
    """Replace this process by one that removes segments without owner: the middleware's own go with its memory.

    Of several processes that end together the last one finds all segments without owner.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os.closerange(3, _MOST_FILES)  # they would keep their locks
    os.execv(sys.executable, [sys.executable, "-m", "flexros_nodes.shell.shared_memory"])  # noqa: S606 - our own module


def _files(folder: Path) -> dict[str, list[Path]]:
    """List the files of each segment of this user, by its name."""
    files: dict[str, list[Path]] = {}
    for path in folder.iterdir():
        if (match := _NAME.match(path.name)) and _is_ours(path):
            files.setdefault(match[1], []).append(path)
    return files


def _is_ours(path: Path) -> bool:
    with suppress(OSError):  # gone meanwhile
        return path.stat().st_uid == os.getuid()
    return False


def _mapped_names(folder: Path, processes: Path) -> set[str]:
    names = set()
    for maps in processes.glob("[0-9]*/maps"):
        with suppress(OSError):  # ended meanwhile, or another user's
            for line in maps.read_text(encoding="utf-8", errors="replace").splitlines():
                _, _, name = line.partition(f"{folder}/")
                if match := _NAME.match(name.removesuffix(" (deleted)")):
                    names.add(match[1])
    return names


def _unlocked(folder: Path, name: str) -> bool:
    try:
        with (folder / f"{name}{LOCK_SUFFIX}").open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True


if __name__ == "__main__":
    remove_segments_without_owner()
