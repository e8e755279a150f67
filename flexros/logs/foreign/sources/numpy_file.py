"""NumPy archives of arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar
from zipfile import BadZipFile

import numpy as np

from flexros.errors import InputError
from flexros.logs.foreign.signal_source import AbstractSignalSource, Signal, flatten

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


class NumpyFile(AbstractSignalSource):
    """Vectors, matrices and structured arrays of an .npz file; pickled objects are never loaded."""

    format: ClassVar[str] = "NumPy archive"
    suffixes: ClassVar[tuple[str, ...]] = (".npz",)

    def __init__(self, path: Path) -> None:
        try:
            with np.load(path, allow_pickle=False) as archive:
                self._columns = flatten({name: archive[name] for name in archive.files})
        except (ValueError, BadZipFile, EOFError, OSError, AttributeError, KeyError) as error:
            raise InputError(
                f"{path} cannot be read as a NumPy archive of plain arrays ({str(error).splitlines()[0]}); write it "
                "with numpy.savez"
            ) from error

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the vectors, of the columns of matrices, and of the fields of structured arrays."""
        return tuple(self._columns)

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Hand the columns out; see `AbstractSignalSource.read`."""
        return {name: Signal(self._columns[name]) for name in names}
