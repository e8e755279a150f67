"""JSON files: a list of samples, one sample per line, or arrays by name."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_NODE, LARGEST_JSON, MOST_SIGNALS
from flexros.logs.foreign.signal_source import AbstractColumns, first_line, flatten

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray

_LINES = (".jsonl", ".ndjson")
"""Suffixes of files with one sample per line."""


class JsonFile(AbstractColumns):
    """Numbers of a JSON file by name.

    Samples are objects in a list, or one per line; their entries are columns, those of a list in them are `q[0]`,
    `q[1]`, ..., and those of an object in them are named with a dot. A file with arrays by name is read like a NumPy
    archive, and a list of rows like a table without names. null, and an entry that a sample lacks, are NaN.
    """

    format: ClassVar[str] = "JSON"
    suffixes: ClassVar[tuple[str, ...]] = (".json", *_LINES)

    def __init__(self, path: Path) -> None:
        if (size := path.stat().st_size) > LARGEST_JSON:
            raise InputError(
                f"{path} has {size} bytes, allowed are {LARGEST_JSON} for a JSON file; give it as CSV or NumPy archive"
            )
        try:
            content = _content(path)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path} cannot be read as JSON ({first_line(error)}); correct it") from error
        try:
            self.columns = flatten(dict(_arrays(content, "", 0)))
        except InputError as error:
            raise InputError(f"{path}: {error}") from error


def _content(path: Path) -> object:
    text = path.read_text(encoding="utf-8-sig")
    if path.suffix.lower() not in _LINES:
        return json.loads(text)
    return [json.loads(line) for line in text.splitlines() if line.strip()]


def _arrays(value: object, name: str, depth: int) -> Iterator[tuple[str, FloatArray]]:
    """Yield the arrays of numbers in a value, with their names."""
    if depth > DEEPEST_NODE:
        raise InputError(f"'{name}' has more than {DEEPEST_NODE} levels; save the signals of the log alone")
    if isinstance(value, dict):
        for key, entry in cast("Mapping[str, object]", value).items():
            yield from _arrays(entry, f"{name}.{key}" if name else key, depth + 1)
    elif isinstance(value, list) and value:
        kinds = {type(entry) for entry in cast("Sequence[object]", value)} - {type(None)}
        if kinds == {dict}:
            yield from _arrays(_transposed(value), name, depth + 1)
        elif kinds <= {int, float, bool} or kinds == {list}:
            array = _array(value)
            if array is not None:
                yield name, array


def _transposed(samples: Sequence[Mapping[str, object] | None]) -> dict[str, list[object]]:
    """Return the entries of samples by name, None where a sample lacks one."""
    names: dict[str, None] = {}
    for sample in samples:
        names.update(dict.fromkeys(sample or ()))
        if len(names) > MOST_SIGNALS:
            raise InputError(f"its samples have more than {MOST_SIGNALS} entries; save the signals of the log alone")
    return {name: [sample.get(name) if sample else None for sample in samples] for name in names}


def _array(value: Sequence[object]) -> FloatArray | None:
    """Return a list of numbers or of rows of numbers as an array; None for other lists."""
    width = max((len(entry) for entry in value if isinstance(entry, list)), default=0)
    rows = [[None] * width if entry is None and width else entry for entry in value]
    if any(isinstance(number, str) for row in rows if isinstance(row, list) for number in row):
        return None
    try:
        return np.array(rows, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return None
