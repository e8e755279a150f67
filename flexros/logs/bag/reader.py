"""The reader of a message file by its storage."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from flexros.logs.mcap.file_reader import McapFileReader
from flexros.logs.sqlite.file_reader import SUFFIX, SqliteFileReader

if TYPE_CHECKING:
    from pathlib import Path

BagFileReader: TypeAlias = McapFileReader | SqliteFileReader
"""One pass through a file: `blocks`, and what it fills, `schemas`, `channels` and `warnings`."""


def bag_file_reader(path: Path) -> BagFileReader:
    """Return a reader of one file of a bag.

    Args:
        path: An .mcap or a .db3 file.
    """
    return SqliteFileReader(path) if path.suffix == SUFFIX else McapFileReader(path)
