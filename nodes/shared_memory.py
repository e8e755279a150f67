"""Shared memory that a killed process leaves behind, free of ROS."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # systems without POSIX locks have no such segments either
    fcntl = None  # type: ignore[assignment]

FOLDER = Path("/dev/shm")  # noqa: S108 - where Linux keeps shared memory
PREFIXES = ("fastrtps_", "fastdds_")
LOCK_SUFFIX = "_el"


def remove_segments_without_owner(folder: Path = FOLDER) -> list[str]:
    """Remove Fast DDS segments of this user whose owner is gone.

    The owner of a segment holds a lock on the file `<segment>_el` beside it as long as it lives; who can take that lock
    knows that the owner is gone. This is the rule by which Fast DDS itself cleans up.

    Args:
        folder: Where segments lie.

    Returns:
        Names of the removed segments.
    """
    removed: list[str] = []
    if fcntl is None or not folder.is_dir():
        return removed
    for lock in sorted(folder.iterdir()):
        if not (lock.name.startswith(PREFIXES) and lock.name.endswith(LOCK_SUFFIX)):
            continue
        with suppress(OSError):  # another user's, or gone meanwhile
            if lock.stat().st_uid == os.getuid() and _can_lock(lock):
                segment = lock.with_name(lock.name.removesuffix(LOCK_SUFFIX))
                for path in (segment, lock.with_name(f"sem.{segment.name}_mutex")):
                    path.unlink(missing_ok=True)
                lock.unlink(missing_ok=True)
                removed.append(segment.name)
    return removed


def _can_lock(path: Path) -> bool:
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
