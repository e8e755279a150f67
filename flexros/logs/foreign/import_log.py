"""Import of a foreign log: columns to quantities, units to SI, times to stamps."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from dataclasses import dataclass
from fnmatch import fnmatch
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.logs.foreign.quantities import QUANTITIES, TIME_UNITS
from flexros.logs.foreign.signal_source import AbstractSignalSource, open_source, safe_name
from flexros.logs.mcap.bag_files import find_bag_files
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import JointSeries, Log
from flexros.one_line import one_line
from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.logs.foreign.mapping import LogMapping, MappedColumn
    from flexros.logs.foreign.signal_source import Signal

_FEWEST = 2
"""Smallest number of rows of a log."""

_PART = 2**20
"""Bytes of a file that are read at once [byte]."""


@dataclass(frozen=True, eq=False)
class _Mapped:
    """A column as a quantity: values in SI units, shape (n,), at times [s] of the file's clock, shape (n,).

    Times count from `origin` [ns], the same for all columns.
    """

    entry: MappedColumn
    column: str
    time: FloatArray
    values: FloatArray
    origin: int
    notes: tuple[str, ...]


def import_log(mapping: LogMapping, files: Sequence[Path]) -> Log:
    """Read files of another recorder as a log.

    The columns may be in several files of the same clock. The first row gets the stamp 1 s; the provenance keeps its
    time in the file. Quantities of one topic that were sampled at different times (other file, other time offset) are
    interpolated linearly at the times of the topic's first quantity; the warnings report it.

    Args:
        mapping: Quantity and unit of every column.
        files: CSV, MATLAB or NumPy files, or ROS 2 bags: .mcap files or rosbag2 folders.

    Returns:
        The log; its provenance names mapping, files and their hashes.

    Raises:
        InputError: A column is missing, not numeric, not finite or too short, or times do not increase; the message
            names file, column and row.
    """
    sources = {path: open_source(path) for path in files}
    present, absent = _find(mapping, sources)
    signals = _read(mapping, sources, present)
    zero = min(float(signal.time[0]) for signal in signals)
    warnings = [f"optional column '{name}' is in none of the files" for name in absent]
    warnings += [note for signal in signals for note in signal.notes]
    topics: dict[str, list[_Mapped]] = defaultdict(list)
    for signal in signals:
        topics[QUANTITIES[signal.entry.quantity].topic].append(signal)
    series: dict[str, Any] = {name: _series(group, zero, warnings) for name, group in topics.items()}
    return Log(
        **series,
        provenance=_provenance(mapping, files, zero + 1e-9 * signals[0].origin, warnings),
        warnings=tuple(map(one_line, warnings)),
    )


def _find(
    mapping: LogMapping, sources: dict[Path, AbstractSignalSource]
) -> tuple[list[tuple[Path, MappedColumn]], list[str]]:
    """Return the file of each column, and the optional columns that no file has."""
    present, absent = [], []
    for entry in mapping.columns:
        holders = [path for path in sources if not entry.file or fnmatch(path.name, entry.file)]
        having = [path for path in holders if entry.column in sources[path].names]
        if len(having) > 1:
            raise InputError(
                f"mapping {mapping.name}: column '{entry.column}' is in several files "
                f"({', '.join(path.name for path in having)}); add the key 'file' to the column"
            )
        if having:
            present.append((having[0], entry))
        elif entry.optional:
            absent.append(entry.column)
        else:
            names = [name for path in holders for name in sources[path].names]
            where = ", ".join(str(path) for path in holders) or f"any file like '{entry.file}'"
            raise unknown_name(f"column of mapping {mapping.name}", entry.column, names, where)
    return present, absent


def _read(
    mapping: LogMapping, sources: dict[Path, AbstractSignalSource], present: list[tuple[Path, MappedColumn]]
) -> list[_Mapped]:
    """Read, check and convert all columns, file by file; return them in the order of the mapping."""
    clock = mapping.time.column if mapping.time else ""
    read: dict[Path, dict[str, Signal]] = {}
    for path, source in sources.items():
        columns = {entry.column: None for holder, entry in present if holder == path}
        if not columns:
            raise InputError(f"{path} has none of the columns of mapping {mapping.name}; leave the file out")
        read[path] = source.read([*columns, *([clock] if clock in source.names and clock not in columns else [])])
    origin = min(signal.origin for signals in read.values() for signal in signals.values())
    mapped = []
    for path, entry in present:
        signal, column = read[path][entry.column], f"{path}, column '{entry.column}'"
        _check_finite(signal.values, column)
        time = _times(mapping, signal, read[path], sources[path].names, column, str(path))
        time = time + ((signal.origin - origin) * 1e-9 + entry.time_offset)
        values = entry.factor * signal.values + entry.offset
        mapped.append(_Mapped(entry, column, time, values, origin, signal.notes))
    return mapped


def _times(
    mapping: LogMapping, signal: Signal, signals: dict[str, Signal], names: Sequence[str], column: str, path: str
) -> FloatArray:
    """Return the times of a signal [s]: its own, or those of the mapping's clock."""
    clock = mapping.time
    if signal.time is not None:
        time, clock_name = signal.time, column
    elif clock is None:
        raise InputError(
            f"mapping {mapping.name} has no key time, but {path} has no times of its own; add time: {{column: NAME}} "
            "or time: {rate: HZ}"
        )
    elif clock.rate is not None:
        time, clock_name = np.arange(len(signal.values)) / clock.rate, f"{path}, time column ''"
    elif clock.column in signals:
        time, clock_name = (
            signals[clock.column].values * TIME_UNITS[clock.unit],
            f"{path}, time column '{clock.column}'",
        )
    else:
        raise unknown_name(f"time column of mapping {mapping.name}", clock.column, names, path)
    if len(time) != len(signal.values):
        raise InputError(
            f"{column} has {len(signal.values)} rows, but its time '{clock.column if clock else ''}' has {len(time)}; "
            "make them equally long"
        )
    _check_increasing(time, clock_name)
    return time


def _check_finite(values: FloatArray, column: str) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            f"{column}, row {bad[0] + 1}: {values[bad[0]]} is not finite ({bad.size} such rows); remove these rows "
            "or fill the gap"
        )


def _check_increasing(time: FloatArray, column: str) -> None:
    if len(time) < _FEWEST:
        raise InputError(f"{column} has {len(time)} rows, but at least {_FEWEST} are needed; give a longer log")
    _check_finite(time, column)
    bad = np.flatnonzero(np.diff(time) <= 0)
    if bad.size:
        row = int(bad[0])
        word = "repeats" if time[row + 1] == time[row] else "goes back"
        raise InputError(
            f"{column}, row {row + 2}: the time {word} ({time[row]:.9g} s, then {time[row + 1]:.9g} s; {bad.size} such "
            "rows), but must increase; sort the rows and drop repeats"
        )


def _series(signals: list[_Mapped], zero: float, warnings: list[str]) -> JointSeries:
    """Interpolate the quantities of one topic at the times of the first and stack the joints."""
    joints = sorted({signal.entry.joint for signal in signals}, key=lambda name: int(name.split("_")[1]))
    base = signals[0]
    moved = [signal for signal in signals if not np.array_equal(signal.time, base.time)]
    inside = np.ones(len(base.time), bool)
    for signal in moved:
        inside &= (base.time >= signal.time[0]) & (base.time <= signal.time[-1])
        warnings.append(
            f"{signal.entry.quantity} of {signal.entry.joint} was interpolated linearly at the times of "
            f"{base.entry.quantity} of {base.entry.joint}"
        )
    time = base.time[inside]
    if len(time) < _FEWEST:
        raise InputError(f"{base.column} and {moved[0].column} have no time in common; correct the clocks")
    fields: dict[str, dict[str, FloatArray]] = defaultdict(dict)
    for signal in signals:
        own = signal.values[inside] if signal not in moved else np.interp(time, signal.time, signal.values)
        fields[QUANTITIES[signal.entry.quantity].field][signal.entry.joint] = own
    quantities = {QUANTITIES[signal.entry.quantity].field: signal.entry.quantity for signal in signals}
    for field, values in fields.items():
        missing = [joint for joint in joints if joint not in values]
        if missing:
            raise InputError(
                f"the quantity {quantities[field]} is mapped for {', '.join(values)} but not for {', '.join(missing)}; "
                "map it for all joints or for none"
            )
    stamp = START_NS + np.rint((time - zero) * 1e9).astype(np.int64)
    stacked: dict[str, Any] = {field: np.column_stack([v[joint] for joint in joints]) for field, v in fields.items()}
    return JointSeries(stamp, tuple(joints), **stacked)


def _provenance(mapping: LogMapping, files: Sequence[Path], zero: float, warnings: list[str]) -> dict[str, Any]:
    return {
        "import": {
            "mapping": mapping.model_dump(mode="json", exclude_defaults=True),
            "files": [{"name": safe_name(path), "sha256": _digest(path)} for path in _single(files)],
            "time_of_first_row_s": zero,
            "warnings": list(warnings),
        },
        "versions": versions(),
    }


def _single(paths: Sequence[Path]) -> list[Path]:
    """Return the files, those of a bag one by one."""
    return [file for path in paths for file in (find_bag_files(path).files if path.is_dir() else (path,))]


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while part := file.read(_PART):
            digest.update(part)
    return digest.hexdigest()
