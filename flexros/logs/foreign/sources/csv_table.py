"""Text tables: columns separated by comma, semicolon, tab or blanks, with a line of names."""

from __future__ import annotations

import csv
import warnings
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import LONGEST_LINE
from flexros.logs.foreign.signal_source import AbstractSignalSource, Signal, first_line

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_DELIMITERS = (",", ";", "\t")
_COMMENT = "#"


class CsvTable(AbstractSignalSource):
    """A table whose first line, commented out or not, names the columns; further lines with # are skipped."""

    format: ClassVar[str] = "table as text"
    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".tsv", ".txt", ".dat")

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines_before, self._delimiter, self._names = _header(path)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns as in the first line."""
        return self._names

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Read columns; see `AbstractSignalSource.read`."""
        columns = [self._names.index(name) for name in names]
        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "loadtxt: input contained no data", UserWarning)  # reported below
                table = np.loadtxt(
                    self._path,
                    delimiter=self._delimiter,
                    comments=_COMMENT,
                    skiprows=self._lines_before,
                    usecols=columns,
                    ndmin=2,
                    quotechar='"',
                    encoding="utf-8-sig",
                )
        except (ValueError, IndexError) as error:
            raise self._first_fault(columns, error) from error
        if not len(table):
            raise InputError(
                f"{self._path} has no rows below its line of names ({', '.join(self._names)}); give a table with "
                "rows of numbers"
            )
        return {name: Signal(table[:, k].copy()) for k, name in enumerate(names)}

    def _first_fault(self, columns: list[int], error: Exception) -> InputError:
        """Return the error that names the first entry that is not a number."""
        with self._path.open(encoding="utf-8-sig", newline="", errors="replace") as file:
            for number, line in enumerate(file, start=1):
                if number <= self._lines_before or not line.split(_COMMENT)[0].strip():
                    continue
                cells = _cells(line.split(_COMMENT)[0], self._delimiter)
                for column in columns:
                    cell = cells[column] if column < len(cells) else None
                    if cell is None or not _is_number(cell):
                        given = "is missing" if not cell else f"is '{cell}', which is not a number"
                        return InputError(
                            f"{self._path}, line {number}: column '{self._names[column]}' {given}; correct the line"
                        )
        return InputError(f"{self._path} cannot be read as a table ({first_line(error)}); correct it")


def _header(path: Path) -> tuple[int, str | None, tuple[str, ...]]:
    """Return the number of the line with the names, the delimiter (None: blanks), and the names."""
    commented: tuple[int, str] | None = None
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = iter(partial(file.readline, LONGEST_LINE), "")
            for number, line in enumerate(lines, start=1):
                if len(line) == LONGEST_LINE:
                    raise InputError(
                        f"{path}, line {number} has {LONGEST_LINE} characters or more; give a table with a row per line"
                    )
                if line.startswith(_COMMENT):
                    commented = (number, line.lstrip(_COMMENT).strip())
                elif line.strip():
                    first = (number, line.strip())
                    break
            else:
                raise InputError(f"{path} has no rows; give a table with a line of names and rows of numbers")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not text (byte {error.start} is not UTF-8); give a table as text") from error
    number, text = first
    delimiter = next((d for d in _DELIMITERS if d in text), None)
    try:
        names = _cells(text, delimiter)
    except csv.Error as error:
        raise InputError(f"{path}, line {number} cannot be divided into columns ({error}); correct it") from error
    if any(_is_number(name) for name in names):
        if commented is None or len(_cells(commented[1], delimiter)) != len(names):
            raise InputError(
                f"{path}, line {number}: the first line holds '{names[0]}', but must name the columns; add such a line"
            )
        number, names = number - 1, _cells(commented[1], delimiter)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{path}, line {number}: the column name '{twice[0]}' occurs twice; rename one")
    return number, delimiter, tuple(names)


def _cells(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line.strip("\r\n")], delimiter=delimiter), [])]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
