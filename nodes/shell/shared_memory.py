"""Removal of shared memory left behind by killed processes."""

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
except ImportError:  # systems without POSIX locks have no such segments
    fcntl = None  # type: ignore[assignment]

FOLDER = Path("/dev/shm")  # noqa: S108 - where Linux keeps shared memory
PROCESSES = Path("/proc")
LOCK_SUFFIX = "_el"
_MOST_FILES = 65_536
_ATTEMPTS, _PAUSE = 5, 0.05
"""Attempts while an unmapped segment is locked (another cleaner tests its lock), and seconds between (chosen)."""

_NAME = re.compile(r"^(?:sem\.)?((?:fastrtps|fastdds)_[a-z0-9]+)(?:_el|_sl|_mutex)?$")


def remove_segments_without_owner(folder: Path = FOLDER, processes: Path = PROCESSES) -> list[str]:
    """Remove Fast DDS segments of this user that no process uses.

    A segment is in use when a process has mapped it or holds a lock on the file `<segment>_el`, the criterion of Fast
    DDS itself. Call it after the processes that used the segments have exited: a live partner would recreate them.

    Args:
        folder: Folder of the segments.
        processes: Proc file system.

    Returns:
        Names of the removed segments.
    """
    removed: list[str] = []
    if fcntl is None or not folder.is_dir():
        return removed
    for attempt in range(_ATTEMPTS):
        if attempt:
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
    """Replace this process by one that removes unused segments; the old memory releases those of this process.

    Of several processes that exit together the last one finds all segments unused.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os.closerange(3, _MOST_FILES)  # they hold locks
    os.execv(sys.executable, [sys.executable, "-m", "flexros_nodes.shell.shared_memory"])  # noqa: S606 - our own module


def _files(folder: Path) -> dict[str, list[Path]]:
    """Return the files of each segment of this user by segment name."""
    files: dict[str, list[Path]] = {}
    for path in folder.iterdir():
        if (match := _NAME.match(path.name)) and _is_ours(path):
            files.setdefault(match[1], []).append(path)
    return files


def _is_ours(path: Path) -> bool:
    with suppress(OSError):  # removed in the meantime
        return path.stat().st_uid == os.getuid()
    return False


def _mapped_names(folder: Path, processes: Path) -> set[str]:
    names = set()
    for maps in processes.glob("[0-9]*/maps"):
        with suppress(OSError):  # exited in the meantime, or of another user
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
