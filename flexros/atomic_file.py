"""Atomic writing of files: readers see the old or the new content."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path


def write_whole(path: Path, text: str | bytes) -> None:
    """Write a file under a temporary name, then rename it.

    Args:
        path: The file; an existing one is replaced when the new one is complete.
        text: Its content, text in UTF-8 or bytes.

    Raises:
        OSError: It could not be written; the old file is unchanged.
    """
    temporary = path.with_name(f".{path.name}.part")
    try:
        if isinstance(text, bytes):
            temporary.write_bytes(text)
        else:
            temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def write_result(path: Path, text: str | bytes, what: str) -> None:
    """Write a result requested by a user.

    Args:
        path: The file; an existing one is replaced when the new one is complete.
        text: Its content, text or bytes.
        what: Kind of the result, e.g. "report", for the error message.

    Raises:
        InputError: It cannot be written there.
    """
    if not path.name:
        raise InputError(f"the {what} cannot be written to '{path}', which is a folder; give a file")
    try:
        write_whole(path, text)
    except OSError as error:
        raise InputError(
            f"the {what} cannot be written to '{path}' ({error.strerror or error}): its folder must exist and be "
            "writable; give another file"
        ) from error
