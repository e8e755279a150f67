"""Files that signals of a foreign log come from: one class per format, found by the suffix of the file."""

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


BAG_SUFFIX = ".mcap"
"""Suffix of a ROS 2 bag; a folder of such files stands for one file."""


@dataclass(frozen=True, eq=False)
class Signal:
    """Numbers of one column.

    Attributes:
        values: Numbers as they stand in the file, shape (n,).
        time: Their times [s], shape (n,), where the format itself has them; None where the mapping's clock says them.
        origin: What the times count from [ns]: as numbers of seconds alone, today's dates are exact to 0.2 us only.
        notes: What was left out or repaired, a sentence each.
    """

    values: FloatArray
    time: FloatArray | None = None
    origin: int = 0
    notes: tuple[str, ...] = ()


class AbstractSignalSource(ABC):
    """A file that holds signals by name.

    A new format is one file in the package `sources` with one final subclass that provides
      1. `format`, its name in words, e.g. "CSV table";
      2. `suffixes`, the endings of its files, in small letters;
      3. `__init__(path)`, which opens the file and raises InputError when it is not of the format;
      4. `names`, the signals that can be read;
      5. `read(names)`, the signals themselves; a name that is not among `names` is never asked for.

    Where the format has times of its own, as a ROS bag does, a signal brings them along in `Signal.time`. The import
    takes them before the mapping's clock, and puts signals of unequal times of one topic on one time base.

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
            names: Which; all of them are among `names`.

        Returns:
            Signals by name.

        Raises:
            InputError: Something in them is no number.
        """


def open_source(path: Path) -> AbstractSignalSource:
    """Open a file of a foreign log.

    Args:
        path: The file; its suffix says the format. A folder is a rosbag2 folder.

    Returns:
        The source of its signals.

    Raises:
        InputError: There is no such file, or its format is not known.
    """
    if not path.exists():
        raise InputError(f"there is no file {path}; give the path of a CSV, MATLAB or NumPy file, or of a ROS 2 bag")
    suffix = BAG_SUFFIX if path.is_dir() else path.suffix.lower()
    kinds = members("flexros.logs.foreign.sources", AbstractSignalSource, "format")  # type: ignore[type-abstract]
    for kind in kinds.values():
        if suffix in kind.suffixes:
            return kind(path)
    known = ", ".join(f"{suffix} ({kind.format})" for kind in kinds.values() for suffix in kind.suffixes)
    raise InputError(f"{path} ends with '{path.suffix}', but allowed are {known}; convert the file")


def flatten(arrays: Mapping[str, object]) -> dict[str, FloatArray]:
    """Make columns of the arrays of a file.

    A vector is one column under its name, a matrix with n rows is the columns name[0], name[1], ...; what stands in a
    structure is named by dots. Numbers that stand alone, texts and everything else are left out.

    Args:
        arrays: Arrays and nested structures by name.

    Returns:
        Columns by name, each of shape (n,).

    Raises:
        InputError: There are more than `MOST_SIGNALS`.
    """
    columns: dict[str, FloatArray] = {}
    for name, value in _plain_arrays(arrays, ""):
        array = np.squeeze(value)
        if array.dtype.kind not in "fiub" or array.size < 2 or array.ndim > 2:
            continue
        n = 1 if array.ndim == 1 else array.shape[1]
        if len(columns) + n > MOST_SIGNALS:
            raise InputError(
                f"it has more than {MOST_SIGNALS} columns; is a matrix transposed? Its rows must be samples"
            )
        if array.ndim == 1:
            columns[name] = array.astype(np.float64)
        else:
            columns.update({f"{name}[{k}]": array[:, k].astype(np.float64) for k in range(n)})
    return columns


def _plain_arrays(arrays: Mapping[str, object], prefix: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Arrays without structure, those of structures one by one, with their names."""
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
    """First line of an error of a library, or its kind where it says nothing."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def safe_name(path: Path) -> str:
    """Name of a file without folders and control characters, for provenance."""
    return re.sub(r"[\x00-\x1f]", "?", path.name)
