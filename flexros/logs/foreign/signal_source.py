"""Contract of the file formats of foreign logs: one class per format, found by the suffix of the file."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from flexros.discovery import members
from flexros.errors import InputError
from flexros.input_limits import MOST_SIGNALS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from flexros.arrays import FloatArray


BAG_SUFFIXES = (".mcap", ".db3")
"""Suffixes of a ROS 2 bag; a folder of such files is read like one file."""


ROS_1 = ".bag"
"""Suffix of a bag of ROS 1, which is not read."""


@dataclass(frozen=True, eq=False)
class Signal:
    """Numbers of one column.

    Attributes:
        values: Numbers in the unit of the file, shape (n,).
        time: Their times [s], shape (n,), if the format has them; None if the mapping's clock defines them.
        origin: Origin of the times [ns]: dates of today in seconds alone would be exact to 0.2 us only.
        notes: What was left out or repaired, one sentence each.
    """

    values: FloatArray
    time: FloatArray | None = None
    origin: int = 0
    notes: tuple[str, ...] = ()


class AbstractSignalSource(ABC):
    """A file that holds signals by name.

    A new format is one file in the package `sources` with one final subclass that provides
      1. `format`, its name in words, e.g. "CSV table";
      2. `suffixes`, the suffixes of its files, in lower case;
      3. `__init__(path)`, which opens the file and raises InputError if it is not of the format;
      4. `names`, the signals that can be read;
      5. `read(names)`, the signals themselves; only names among `names` are requested.

    A format with times of its own, such as a ROS bag, sets `Signal.time`. The import prefers these times to the
    mapping's clock, and interpolates signals of one topic with different times to one time base.

    Args:
        path: The file.
    """

    format: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]

    @abstractmethod
    def __init__(self, path: Path) -> None: ...

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the signals, in the order of the file."""

    @abstractmethod
    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Read signals.

        Args:
            names: Their names, all among `names`.

        Returns:
            Signals by name.

        Raises:
            InputError: An entry is not a number.
        """


class AbstractColumns(AbstractSignalSource):
    """A file that is read as a whole when it is opened; a format provides its `columns` then."""

    columns: Mapping[str, FloatArray]
    """Columns by name, each of shape (n,)."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the vectors, of the columns of matrices, and of the entries of structures."""
        return tuple(self.columns)

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Return the columns; see `AbstractSignalSource.read`."""
        return {name: Signal(self.columns[name]) for name in names}


def open_source(path: Path) -> AbstractSignalSource:
    """Open a file of a foreign log.

    Args:
        path: The file; its suffix determines the format. A folder is a rosbag2 folder.

    Returns:
        The source of its signals.

    Raises:
        InputError: There is no such file, its format is not known, or it holds no numbers.
    """
    if not path.exists():
        raise InputError(
            f"there is no file {path}; give the path of a CSV, MATLAB, NumPy or JSON file, or of a ROS 2 bag"
        )
    suffix = BAG_SUFFIXES[0] if path.is_dir() else path.suffix.lower()
    kinds = members("flexros.logs.foreign.sources", AbstractSignalSource, "format")  # type: ignore[type-abstract]
    for kind in kinds.values():
        if suffix in kind.suffixes:
            source = kind(path)
            if isinstance(source, AbstractColumns) and not source.names:
                raise InputError(
                    f"{path} holds no vector or matrix of numbers; objects, tables and texts are not read, nor cells "
                    "of different lengths: save each signal as a plain array"
                )
            return source
    if suffix == ROS_1:
        raise InputError(
            f"{path} is a bag of ROS 1; convert it to one of ROS 2 by the command rosbags-convert of the package "
            "rosbags ('pip install rosbags')"
        )
    known = ", ".join(f"{suffix} ({kind.format})" for kind in kinds.values() for suffix in kind.suffixes)
    raise InputError(f"{path} ends with '{path.suffix}', but allowed are {known}; convert the file")


def flatten(arrays: Mapping[str, object]) -> dict[str, FloatArray]:
    """Convert the arrays of a file to columns.

    A vector is one column with its name, a matrix with n samples is the columns name[0], name[1], ...; its samples are
    along its longer side, because a log has more of them than signals. Entries of a structure are named with dots.
    Cells or lists of vectors of one length are a matrix with a sample in each. Scalars, texts and everything else are
    ignored.

    Args:
        arrays: Arrays and nested structures by name.

    Returns:
        Columns by name, each of shape (n,).

    Raises:
        InputError: There are more than `MOST_SIGNALS`.
    """
    columns: dict[str, FloatArray] = {}
    for name, value in _plain_arrays(arrays, ""):
        array = _samples_of_cells(np.squeeze(value))
        if array.dtype.kind not in "fiub" or array.size < 2 or array.ndim > 2:
            continue
        if array.ndim == 1:
            signals = {name: array}
        else:
            by_sample = array if array.shape[0] >= array.shape[1] else array.T
            signals = {f"{name}[{k}]": column for k, column in enumerate(by_sample.T)}
        if len(columns) + len(signals) > MOST_SIGNALS:
            raise InputError(f"it has more than {MOST_SIGNALS} columns; save the signals of the log alone")
        columns.update({title: np.array(column, dtype=np.float64) for title, column in signals.items()})
    return columns


def _samples_of_cells(array: NDArray[Any]) -> NDArray[Any]:
    """Stack cells that hold a vector of numbers each, all of one length, a sample in a row; else the array as it is."""
    if array.dtype.kind != "O" or array.ndim != 1 or not array.size:
        return array
    cells = [np.ravel(cell) if isinstance(cell, (np.ndarray, list, tuple, float, int)) else None for cell in array]
    first = cells[0]
    if first is None or not first.size or any(cell is None or cell.size != first.size for cell in cells):
        return array
    samples = np.stack([cell for cell in cells if cell is not None])
    return samples[:, 0] if samples.shape[1] == 1 else samples


def _plain_arrays(arrays: Mapping[str, object], prefix: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield plain arrays with their names, those of structures one by one."""
    for key, value in arrays.items():
        name = f"{prefix}{key}"
        array = None if isinstance(value, dict) else np.asarray(value)
        if array is None:
            yield from _plain_arrays(cast("dict[str, object]", value), f"{name}.")
        elif array.dtype.names:
            yield from _plain_arrays({field: array[field] for field in array.dtype.names}, f"{name}.")
        else:
            yield name, array


def first_line(error: Exception) -> str:
    """Return the first line of an error of a library, or its type if it has no text."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def safe_name(path: Path) -> str:
    """Return the name of a file without folders and control characters, for provenance."""
    return re.sub(r"[\x00-\x1f]", "?", path.name)
