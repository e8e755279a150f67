"""MATLAB files: version 5 to 7 by SciPy, version 7.3 (HDF5) where h5py is installed."""

from __future__ import annotations

import importlib
import importlib.util
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexros.errors import InputError
from flexros.logs.foreign.signal_source import AbstractSignalSource, Signal, flatten

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HEADER = 512
"""Bytes that MATLAB puts before the HDF5 part of a file of version 7.3."""


class MatlabFile(AbstractSignalSource):
    """Vectors and matrices of a .mat file; entries of a structure are named structure.entry."""

    format: ClassVar[str] = "MATLAB"
    suffixes: ClassVar[tuple[str, ...]] = (".mat",)

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            begin = file.read(_HEADER + len(_HDF5))
        hdf5 = _HDF5 in (begin[: len(_HDF5)], begin[_HEADER:])
        self._columns = flatten(_read_hdf5(path) if hdf5 else _read_version_5(path))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the vectors and of the columns of matrices."""
        return tuple(self._columns)

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Hand the columns out; see `AbstractSignalSource.read`."""
        return {name: Signal(self._columns[name]) for name in names}


def _read_version_5(path: Path) -> dict[str, object]:
    from scipy.io import loadmat

    try:
        content = loadmat(path, appendmat=False, simplify_cells=True)
    except Exception as error:  # SciPy raises errors of many kinds on damaged files
        raise InputError(
            f"{path} cannot be read as a MATLAB file ({_first_line(error)}); save it again with: save -v7"
        ) from error
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _read_hdf5(path: Path) -> dict[str, object]:
    if importlib.util.find_spec("h5py") is None:
        raise InputError(
            f"{path} is a MATLAB file of version 7.3 (HDF5), which needs the package h5py: pip install h5py, or save "
            "the file again with: save -v7"
        )
    h5py: Any = importlib.import_module("h5py")
    found: dict[str, object] = {}

    def take(name: str, entry: Any) -> None:
        text = entry.attrs.get("MATLAB_class") == b"char"
        if isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiub" and not text and not name.startswith("#"):
            found[name.replace("/", ".")] = np.asarray(entry).T

    try:
        with h5py.File(path, "r") as file:
            file.visititems(take)
    except (OSError, RuntimeError) as error:
        raise InputError(
            f"{path} cannot be read as a MATLAB file of version 7.3 ({_first_line(error)}); save it again with: "
            "save -v7"
        ) from error
    return found


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
