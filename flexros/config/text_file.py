"""Reading text files of limited size."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.input_limits import LARGEST_TEXT

if TYPE_CHECKING:
    from pathlib import Path


def is_file(path: Path) -> bool:
    """Return whether a file exists; False for names that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_text(path: Path, kind: str, largest: int = LARGEST_TEXT) -> str:
    """Read a text file.

    Args:
        path: The file.
        kind: Expected kind, for error messages, e.g. "YAML".
        largest: Largest allowed size [byte].

    Raises:
        InputError: It cannot be read, is larger, or is not UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot read {path}: {reason}; give the path of a readable {kind} file") from error
    if len(content) > largest:
        raise InputError(f"{path} is larger than the {largest} bytes that are allowed for a {kind} file; shorten it")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not a text file (byte {error.start} is not UTF-8); give a {kind} file") from error


def read_json(path: Path, largest: int = LARGEST_TEXT) -> Any:
    """Read a JSON file of at most `largest` bytes.

    Raises:
        InputError: It cannot be read, is too large, or is not JSON.
    """
    text = read_text(path, "JSON", largest)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not JSON ({error}); give a file as it was written") from error
