"""NumPy archives of arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar
from zipfile import ZipFile

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import MOST_ELEMENTS, room_of
from flexros.logs.foreign.signal_source import AbstractColumns, first_line, flatten

if TYPE_CHECKING:
    from pathlib import Path


class NumpyFile(AbstractColumns):
    """Vectors, matrices and structured arrays of an .npz file; pickled objects are never loaded."""

    format: ClassVar[str] = "NumPy archive"
    suffixes: ClassVar[tuple[str, ...]] = (".npz",)

    def __init__(self, path: Path) -> None:
        try:
            _check_claims(path)
            with np.load(path, allow_pickle=False) as archive:
                self.columns = flatten({name: archive[name] for name in archive.files})
        except Exception as error:  # damaged archives fail in many ways
            raise InputError(
                f"{path} cannot be read as a NumPy archive of plain arrays ({first_line(error)}); write it with "
                "numpy.savez"
            ) from error


def _check_claims(path: Path) -> None:
    """Refuse an archive that claims more than a file of its size may hold; no entry unpacks to more than it claims."""
    room = room_of(path.stat().st_size)
    with ZipFile(path) as archive:
        entries = archive.infolist()
    if len(entries) > MOST_ELEMENTS:
        raise InputError(f"it holds {len(entries)} arrays, allowed are {MOST_ELEMENTS}")
    if (size := sum(entry.file_size for entry in entries)) > room:
        raise InputError(f"its arrays claim {size} bytes, allowed are {room} for a file of this size")
