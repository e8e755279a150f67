"""MATLAB files: version 4 to 7 by SciPy, version 7.3 (HDF5) by h5py if it is installed."""

from __future__ import annotations

import importlib
import importlib.util
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import MOST_ELEMENTS, room_of
from flexros.logs.foreign.matlab_elements import check_elements
from flexros.logs.foreign.signal_source import AbstractColumns, first_line, flatten

if TYPE_CHECKING:
    from pathlib import Path

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HEADER = 512
"""Length of the MATLAB header before the HDF5 part of a file of version 7.3 [byte]."""


class MatlabFile(AbstractColumns):
    """Vectors and matrices of a .mat file; entries of a structure are named structure.entry."""

    format: ClassVar[str] = "MATLAB"
    suffixes: ClassVar[tuple[str, ...]] = (".mat",)

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            begin = file.read(_HEADER + len(_HDF5))
        hdf5 = _HDF5 in (begin[: len(_HDF5)], begin[_HEADER:])
        version = "a MATLAB file of version 7.3" if hdf5 else "a MATLAB file"
        if hdf5 and importlib.util.find_spec("h5py") is None:
            raise InputError(
                f"{path} is {version} (HDF5), which needs the package h5py: pip install h5py, or save the file again "
                "with: save -v7"
            )
        try:
            self.columns = flatten(_read_hdf5(path) if hdf5 else _read_version_5(path))
        except Exception as error:  # SciPy and HDF5 raise errors of many kinds on damaged files
            raise InputError(
                f"{path} cannot be read as {version} ({first_line(error)}); save it again with: save -v7"
            ) from error


def _read_version_5(path: Path) -> dict[str, object]:
    from scipy.io import loadmat

    check_elements(path)
    content = loadmat(path, appendmat=False, simplify_cells=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _read_hdf5(path: Path) -> dict[str, object]:
    h5py: Any = importlib.import_module("h5py")
    arrays: dict[str, object] = {}
    room, n_entries = room_of(path.stat().st_size), 0

    def take(name: str, entry: Any) -> None:
        nonlocal room, n_entries
        n_entries += 1
        if n_entries > MOST_ELEMENTS:
            raise InputError(f"it holds more than {MOST_ELEMENTS} arrays and structures")
        if not isinstance(entry, h5py.Dataset) or entry.dtype.kind not in "fiub" or name.startswith("#"):
            return
        if entry.attrs.get("MATLAB_class") == b"char":
            return
        if entry.external or entry.is_virtual:
            raise InputError(f"its array {name} is in another file")
        room -= entry.size * entry.dtype.itemsize
        if room < 0:
            raise InputError(f"its arrays claim more bytes than the {room_of(path.stat().st_size)} that are allowed")
        arrays[name.replace("/", ".")] = np.asarray(entry).T

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return arrays
