"""Compiled objects on disk, so that a process need not compile again what another one has compiled.

One file per object below `FLEXROS_CACHE`, by default `flexros` in the user's cache folder; its name is a fingerprint of
all that determines the code. Only a folder that belongs to the user and that nobody else may write is read, because
what it holds is run. The cache is best effort: whatever cannot be read or written is compiled and not kept.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

VARIABLE = "FLEXROS_CACHE"
"""Environment variable: folder of the cache, or `off`."""

MOST_BYTES = 200_000_000
"""Size of all objects beyond which those unused for longest are removed [bytes], chosen: some 2000 modules."""

USED_AGAIN = 86_400.0
"""Age of the mark of last use from which it is renewed [s], chosen."""

_DIGEST = hashlib.sha256().digest_size


def fingerprint(*parts: str) -> str:
    """Return the name of an object.

    Args:
        parts: All that determines it.
    """
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def kept_or_made(name: str, make: Callable[[], bytes]) -> bytes:
    """Return an object from the cache, or make it and keep it.

    Args:
        name: Its fingerprint.
        make: Compiles it.
    """
    folder = _private_folder(_chosen_folder())
    if folder is None:
        return make()
    path = folder / f"{name}.o"
    content = _read(path)
    if content is None:
        content = make()
        with suppress(OSError):
            _write(path, content)
            _tidy(folder)
    return content


def cache_folder() -> tuple[Path | None, bool]:
    """Return the folder of the objects and whether it can be used; None where the cache is off or the user has no home.

    It is made where it is missing.
    """
    chosen = _chosen_folder()
    folder = _private_folder(chosen)
    if folder is not None:
        return folder, os.access(folder, os.W_OK)
    return (None if chosen is None else chosen / "objects"), False


def _chosen_folder() -> Path | None:
    """Return the folder of this environment; None where the cache is switched off or the user has no home."""
    given = os.environ.get(VARIABLE, "")
    if given:
        return None if given.lower() in ("off", "0", "no") else Path(given).absolute()
    base = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME", "")
    try:
        return (Path(base) if Path(base).is_absolute() else Path.home() / ".cache") / "flexros"
    except RuntimeError:
        return None


@lru_cache(maxsize=8)
def _private_folder(chosen: Path | None) -> Path | None:
    """Make the folder of the objects; None unless it belongs to the user, and to him alone."""
    if chosen is None:
        return None
    folder = chosen / "objects"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        state = folder.lstat()
    except OSError:
        return None
    if os.name == "nt":
        return folder
    others_write = state.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    own = stat.S_ISDIR(state.st_mode) and state.st_uid == os.geteuid() and not others_write
    return folder if own else None


def _read(path: Path) -> bytes | None:
    """Return an object; None if it is not there or not whole."""
    try:
        whole = path.read_bytes()
        if time.time() - path.stat().st_mtime > USED_AGAIN:
            os.utime(path)
    except OSError:
        return None
    digest, content = whole[:_DIGEST], whole[_DIGEST:]
    return content if hashlib.sha256(content).digest() == digest else None


def _write(path: Path, content: bytes) -> None:
    """Write an object under a name of its own, then rename it: readers and other writers see whole ones only."""
    number, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(number, "wb") as file:
            file.write(hashlib.sha256(content).digest() + content)
        Path(temporary).replace(path)
    except OSError:
        Path(temporary).unlink(missing_ok=True)
        raise


@lru_cache(maxsize=8)
def _tidy(folder: Path) -> None:
    """Remove unused objects, once in a process."""
    remove_unused(folder)


def remove_unused(folder: Path, limit: int = MOST_BYTES) -> None:
    """Remove the objects that were unused for longest, down to nine tenths of the limit.

    Args:
        folder: Folder of the objects.
        limit: Size of all objects from which on some are removed [bytes].

    Raises:
        OSError: The folder cannot be read.
    """
    with os.scandir(folder) as entries:
        found = [(entry.stat(), entry.path) for entry in entries if entry.is_file(follow_symlinks=False)]
    size = sum(state.st_size for state, _ in found)
    if size <= limit:
        return
    for state, path in sorted(found, key=lambda one: one[0].st_mtime):
        if size <= 0.9 * limit:
            return
        with suppress(OSError):
            Path(path).unlink()
        size -= state.st_size
