"""Atomic writing of files: readers see the old or the new content."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path


def write_whole(path: Path, text: str | bytes) -> None:
    """Write a file under a name of its own, then rename it: of several writers the last one counts.

    Args:
        path: The file; an existing one is replaced when the new one is complete.
        text: Its content, text in UTF-8 or bytes.

    Raises:
        OSError: It could not be written; the old file is unchanged.
        UnicodeEncodeError: The text holds characters that UTF-8 does not have.
    """
    content = text if isinstance(text, bytes) else text.encode("utf-8")
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    except BaseException:
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
    except UnicodeEncodeError as error:
        raise InputError(
            f"the {what} cannot be written to '{path}': it holds {error.object[error.start : error.end]!a}, which is "
            "no character of UTF-8, as in a file name of another coding; give names in UTF-8"
        ) from error
    except OSError as error:
        raise InputError(
            f"the {what} cannot be written to '{path}' ({error.strerror or error}): its folder must exist and be "
            "writable; give another file"
        ) from error
