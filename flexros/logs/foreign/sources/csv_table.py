"""Text tables: columns separated by comma, semicolon, tab or blanks, with a line of names."""

from __future__ import annotations

import csv
import re
import warnings
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import LONGEST_LINE
from flexros.logs.foreign.signal_source import AbstractSignalSource, Signal, first_line

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray

_DELIMITERS = (",", ";", "\t")
_COMMENT = "#"
_LIST = re.compile(r"[\[(]([^\[\]()]*)[\])]")
"""A list in a cell, such as [0.1, 0.2]."""
_MARK = "\N{SYMBOL FOR NULL}"
"""Stands for a list while a line is divided."""
_BETWEEN = re.compile(r"\s*[,;\s]\s*")
"""Separator of the entries of a list."""


class CsvTable(AbstractSignalSource):
    """A table whose first line, commented out or not, names the columns; further lines with # are skipped.

    Columns of a table without names are called [0], [1], ... A cell may hold a list, e.g. "[0.1, 0.2]" with one entry
    per joint: its column `q` is then the columns q[0], q[1], ... An empty cell is NaN, also one of a list.
    """

    format: ClassVar[str] = "table as text"
    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".tsv", ".txt", ".dat")

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines_before, self._delimiter, names = _header(path)
        cells = self._first_row()
        self._lists = any(_LIST.search(cell) for cell in cells)
        self._sizes = [len(_entries(cell)) for cell in cells]
        self._names = _expanded(names, cells) if self._lists and len(cells) == len(names) else names

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns as in the first line."""
        return self._names

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Read columns; see `AbstractSignalSource.read`."""
        columns = [self._names.index(name) for name in names]
        try:
            table = self._table(columns)
        except (ValueError, IndexError):  # perhaps an empty cell, which the fast way does not know
            try:
                table = self._table(columns, _number)
            except (ValueError, IndexError) as error:
                raise self._first_fault(columns, error) from error
        if not len(table):
            raise InputError(
                f"{self._path} has no rows below its line of names ({', '.join(self._names)}); give a table with "
                "rows of numbers"
            )
        return {name: Signal(table[:, k].copy()) for k, name in enumerate(names)}

    def _table(self, columns: list[int], converter: Callable[[str], float] | None = None) -> FloatArray:
        """Read columns, cells by a converter if one is given, shape (n, n_columns)."""
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "loadtxt: input contained no data", UserWarning)  # reported by `read`
            return np.loadtxt(
                self._plain_lines() if self._lists else self._path,
                delimiter=self._delimiter,
                comments=_COMMENT,
                skiprows=0 if self._lists else self._lines_before,
                usecols=columns,
                converters=converter,
                ndmin=2,
                quotechar='"',
                encoding="utf-8-sig",
            )

    def _first_row(self) -> list[str]:
        """Return the cells of the first row below the names; none where there is no row."""
        for _, line in self._rows():
            return _cells(line, self._delimiter)
        return []

    def _rows(self) -> Iterator[tuple[int, str]]:
        """Yield the lines below the names with their numbers, without comments and blank ones."""
        with self._path.open(encoding="utf-8-sig", newline="", errors="replace") as file:
            for number, line in enumerate(file, start=1):
                text = line.split(_COMMENT)[0].strip("\r\n")
                if number > self._lines_before and text.strip():
                    yield number, text

    def _row_entries(self, line: str) -> list[str]:
        """Divide a line, lists into their entries; an empty cell where the first row has a list stands for all."""
        cells = _cells(line, self._delimiter)
        sizes = self._sizes if len(cells) == len(self._sizes) else [1] * len(cells)
        return [entry for cell, size in zip(cells, sizes) for entry in (_entries(cell) if cell else [""] * size)]

    def _plain_lines(self) -> Iterator[str]:
        """Yield the rows with the entries of lists as cells of their own."""
        between = self._delimiter or " "
        for number, line in self._rows():
            cells = self._row_entries(line)
            if len(cells) != len(self._names):
                raise InputError(
                    f"{self._path}, line {number} has {len(cells)} numbers with those in lists, but the first row has "
                    f"{len(self._names)}; correct the line"
                )
            yield between.join(cells)

    def _first_fault(self, columns: list[int], error: Exception) -> InputError:
        """Return the error that names the first entry that is not a number."""
        for number, line in self._rows():
            cells = self._row_entries(line)
            for column in columns:
                cell = cells[column] if column < len(cells) else None
                if cell is None or (cell and not _is_number(cell)):
                    given = "is missing" if cell is None else f"is '{cell}', which is not a number"
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
    if any(map(_holds_numbers, names)):
        if commented is None or len(_cells(commented[1], delimiter)) != len(names):
            if all(not name or _holds_numbers(name) for name in names):
                return number - 1, delimiter, tuple(f"[{k}]" for k in range(len(names)))
            at = next(k for k, name in enumerate(names) if _holds_numbers(name))
            raise InputError(
                f"{path}, line {number}: the first line holds '{names[at]}' at column {at + 1}, but must name the "
                "columns; add such a line, or name that column by a word"
            )
        number, names = number - 1, _cells(commented[1], delimiter)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{path}, line {number}: the column name '{twice[0]}' occurs twice; rename one")
    return number, delimiter, tuple(names)


def _cells(line: str, delimiter: str | None) -> list[str]:
    """Divide a line; delimiters within a list belong to it, quoted or not."""
    lists = _LIST.findall(line)
    marked = _LIST.sub(_MARK, line)
    if delimiter is None:
        cells = [cell.strip('"') for cell in marked.split()]
    else:
        cells = [cell.strip() for cell in next(csv.reader([marked.strip("\r\n")], delimiter=delimiter), [])]
    if lists and sum(cell == _MARK for cell in cells) == len(lists):
        following = iter(lists)
        return [f"[{next(following)}]" if cell == _MARK else cell for cell in cells]
    return cells if not lists else _divided(line, delimiter)


def _divided(line: str, delimiter: str | None) -> list[str]:
    """Divide a line whose brackets are parts of names."""
    if delimiter is None:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line.strip("\r\n")], delimiter=delimiter), [])]


def _entries(cell: str) -> list[str]:
    """Return the entries of a list in a cell, or the cell."""
    found = _LIST.fullmatch(cell)
    return [cell] if found is None else [entry for entry in _BETWEEN.split(found[1].strip()) if entry]


def _expanded(names: Sequence[str], cells: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns, those of lists one by one."""
    expanded: list[str] = []
    for name, cell in zip(names, cells, strict=True):
        entries = _entries(cell)
        expanded += [name] if _LIST.fullmatch(cell) is None else [f"{name}[{k}]" for k in range(len(entries))]
    return tuple(expanded)


def _holds_numbers(cell: str) -> bool:
    """Whether a cell is a number or a list of numbers."""
    return bool(_entries(cell)) and all(map(_is_number, _entries(cell)))


def _number(cell: str) -> float:
    """Convert a cell; an empty one is NaN."""
    return float(cell) if cell.strip() else np.nan


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
