"""Import of a foreign log: columns to quantities, units to SI, times to stamps."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.logs.bag.files import find_bag_files
from flexros.logs.foreign.mapping import clock_of
from flexros.logs.foreign.message_rows import message_rows
from flexros.logs.foreign.plausibility import doubts
from flexros.logs.foreign.quantities import QUANTITIES, TIME_UNITS
from flexros.logs.foreign.signal_source import AbstractSignalSource, open_source, safe_name
from flexros.logs.foreign.usable_rows import FEWEST, LostValues, check_size, usable_times
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import OWN_SERIES, ImuSeries, JointSeries, Log
from flexros.logs.wrapped_positions import joined
from flexros.one_line import one_line
from flexros.provenance import versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.logs.foreign.mapping import Clock, LogMapping, MappedColumn
    from flexros.logs.foreign.signal_source import Signal

TOOL_FRAME = "tool"
"""Frame of the sensors of the tool."""

_FIELDS_OF_TOOL = {"linear_acceleration": "acceleration", "angular_velocity": "turning_rate"}
"""Fields of the series of an Imu message."""

HOLE = 6.5
"""Interval of a signal, over its usual one, from which nothing is known within it [1] (chosen): up to five lost samples
are bridged, as in a log."""

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

    The columns may be in several files of the same clock, and the times in each of them or in a file of their own. The
    first row gets the stamp 1 s; the provenance keeps its time in the file. Values that are not finite stay NaN, and of
    rows with the same time the first is kept; the warnings count both. Quantities of one topic that were sampled at
    different times (other file, other time offset) are interpolated linearly at the times of the topic's first
    quantity; the warnings report it where those are others.

    Args:
        mapping: Quantity and unit of every column.
        files: CSV, MATLAB, NumPy or JSON files, or ROS 2 bags: .mcap or .db3 files or rosbag2 folders.

    Returns:
        The log; its provenance names mapping, files and their hashes.

    Raises:
        InputError: A column is missing, not numeric, too short or largely not finite, or times go back; the message
            names file, column and row.
    """
    sources = {path: open_source(path) for path in files}
    present, absent = _find(mapping, sources)
    left_out: list[str] = []
    signals = _read(mapping, sources, present, left_out)
    zero = min(float(signal.time[0]) for signal in signals)
    warnings = [f"optional column '{name}' is in none of the files" for name in absent]
    warnings += dict.fromkeys((*(note for signal in signals for note in signal.notes), *left_out))
    topics: dict[str, list[_Mapped]] = defaultdict(list)
    for signal in signals:
        topics[QUANTITIES[signal.entry.quantity].topic].append(signal)
    _add_motor_positions(topics)
    series: dict[str, Any] = {
        name: (_tool_series if QUANTITIES[group[0].entry.quantity].of_tool else _series)(group, zero, warnings)
        for name, group in topics.items()
    }
    warnings += doubts(series)
    return Log(
        **{name: values for name, values in series.items() if name in OWN_SERIES},
        other_series={name: values for name, values in series.items() if name not in OWN_SERIES},
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
        having = [path for path in holders if entry.factors.keys() <= set(sources[path].names)]
        if len(having) > 1:
            raise InputError(
                f"mapping {mapping.name}: column '{entry.label}' is in several files "
                f"({', '.join(path.name for path in having)}); add the key 'file' to the column"
            )
        if having:
            present.append((having[0], entry))
        elif entry.optional:
            absent.append(entry.label)
        else:
            names = [name for path in holders for name in sources[path].names]
            where = ", ".join(str(path) for path in holders) or f"any file like '{entry.file}'"
            missing = next((column for column in entry.factors if column not in names), None)
            if missing is None:
                raise InputError(
                    f"mapping {mapping.name}: the columns {entry.label} of {entry.quantity} are in different files "
                    f"({where}); a sum needs all of them in one"
                )
            raise unknown_name(f"column of mapping {mapping.name}", missing, names, where)
    return present, absent


def _read(
    mapping: LogMapping,
    sources: dict[Path, AbstractSignalSource],
    present: list[tuple[Path, MappedColumn]],
    left_out: list[str],
) -> list[_Mapped]:
    """Read, check and convert all columns, file by file; return them in the order of the mapping."""
    clocks = _clocks(mapping, sources, present)
    wanted: dict[Path, list[str]] = {path: [] for path in sources}
    for (path, entry), (clock, holder) in zip(present, clocks, strict=True):
        wanted[path] += entry.factors
        if clock is not None and clock.column in sources[holder].names:
            wanted[holder].append(clock.column)
    for path, columns in wanted.items():
        if not columns and path not in {holder for _, holder in clocks}:
            raise InputError(f"{path} has none of the columns of mapping {mapping.name}; leave the file out")
    read = {path: sources[path].read(list(dict.fromkeys(columns))) for path, columns in wanted.items()}
    origin = min(signal.origin for signals in read.values() for signal in signals.values())
    messages = _message_rows(read, {clock.column for clock, _ in clocks if clock is not None})
    mapped, lost = [], LostValues()
    for (path, entry), (clock, holder) in zip(present, clocks, strict=True):
        signal, column = _added(entry, read[path], path), f"{path}, column '{entry.label}'"
        time, clock_name = _times(mapping, clock, signal, read[holder], sources[holder].names, column, str(holder))
        rows = messages[path].get(next(iter(entry.factors)))
        if rows is not None and clock is not None and clock.rate is None:
            signal, time = replace(signal, values=signal.values[rows]), time[rows]
            left_out.append(f"{path} has a row for each message: columns count in the rows of theirs")
        used, notes = usable_times(time, clock_name)
        time = time + ((signal.origin - origin) * 1e-9 + entry.time_offset)
        quantity = f"{entry.quantity} of {entry.component}"
        numbers = signal.values if entry.period is None else joined(signal.values, entry.period, used)
        values = lost.marked(entry.factor * numbers + entry.offset, used, str(path), entry.label, quantity)
        check_size(values, signal.values, column)
        mapped.append(_Mapped(entry, column, time[used], values[used], origin, signal.notes))
        left_out += notes
    left_out += lost.notes
    return mapped


def _message_rows(read: dict[Path, dict[str, Signal]], times: set[str]) -> dict[Path, dict[str, BoolArray]]:
    """Return the rows of the message of each column of each file that has a row for each message."""
    return {
        path: message_rows({k: one.values for k, one in signals.items() if one.time is None and k not in times})
        for path, signals in read.items()
    }


def _clocks(
    mapping: LogMapping, sources: dict[Path, AbstractSignalSource], present: list[tuple[Path, MappedColumn]]
) -> list[tuple[Clock | None, Path]]:
    """Return the clock of each column and the file of its times: that of the column, or one that holds times alone."""
    alone = [path for path in sources if path not in {holder for holder, _ in present}]
    clocks = []
    for path, entry in present:
        clock = clock_of(mapping, entry, path.name, [other.name for other in alone])
        holders = [path] if clock is None or _has_times(path, sources, clock) else []
        if clock is not None and not holders:
            holders = [other for other in alone if _has_times(other, sources, clock)]
        if len(holders) > 1:
            raise InputError(
                f"mapping {mapping.name}: the times of {path.name} are in several files "
                f"({', '.join(other.name for other in holders)}); name one of them by the key 'file' of 'time'"
            )
        clocks.append((clock, holders[0] if holders else path))
    return clocks


def _has_times(path: Path, sources: dict[Path, AbstractSignalSource], clock: Clock) -> bool:
    """Whether a clock is that of a file: the one that it names, or one that has its column."""
    return fnmatch(path.name, clock.file) if clock.file else clock.column in sources[path].names


def _added(entry: MappedColumn, signals: dict[str, Signal], path: Path) -> Signal:
    """Return the column of a quantity, or the sum of its columns in the unit of the file."""
    first, *others = (signals[column] for column in entry.factors)
    for column, signal in zip(list(entry.factors)[1:], others, strict=True):
        own, base = (np.arange(len(s.values)) if s.time is None else s.time for s in (signal, first))
        if not np.array_equal(own, base):
            raise InputError(
                f"{path}: the columns {entry.label} are added, but '{column}' was sampled at other times than "
                f"'{next(iter(entry.factors))}'; give columns of the same rows"
            )
    if not others and not entry.sum:
        return first
    values = sum(factor * signals[column].values for column, factor in entry.factors.items())
    return replace(first, values=np.asarray(values), notes=tuple(n for s in (first, *others) for n in s.notes))


def _times(
    mapping: LogMapping,
    clock: Clock | None,
    signal: Signal,
    signals: dict[str, Signal],
    names: Sequence[str],
    column: str,
    path: str,
) -> tuple[FloatArray, str]:
    """Return the times of a signal [s], its own or those of its clock, and where they are from."""
    if signal.time is not None:
        time, clock_name = signal.time, column
    elif clock is None:
        lacks = f"no key time, but {path}" if mapping.time is None else f"no clock for {path}, which"
        raise InputError(
            f"mapping {mapping.name} has {lacks} has no times of its own; add time: {{column: NAME}} or "
            "time: {rate: HZ}"
        )
    elif clock.rate is not None:
        time, clock_name = np.arange(len(signal.values)) / clock.rate + clock.offset, f"{path}, time column ''"
    elif clock.column in signals:
        time, clock_name = (
            signals[clock.column].values * TIME_UNITS[clock.unit] + clock.offset,
            f"{path}, time column '{clock.column}'",
        )
    else:
        raise unknown_name(f"time column of mapping {mapping.name}", clock.column, names, path)
    if len(time) != len(signal.values):
        raise InputError(
            f"{column} has {len(signal.values)} rows, but its time '{clock.column if clock else ''}' of {path} has "
            f"{len(time)}; make them equally long"
        )
    return time, clock_name


def _add_motor_positions(topics: dict[str, list[_Mapped]]) -> None:
    """Add the positions of the motors to deflections, which are measured from there."""
    motors = {signal.entry.joint: signal for signal in topics["joint_states"] if signal.entry.quantity == "position"}
    for signals in topics.values():
        for k, signal in enumerate(signals):
            if not QUANTITIES[signal.entry.quantity].beyond_motor:
                continue
            motor = motors[signal.entry.joint]
            inside = (signal.time >= motor.time[0]) & (signal.time <= motor.time[-1])
            time = signal.time[inside]
            values = signal.values[inside] + np.interp(time, motor.time, motor.values)
            signals[k] = replace(signal, time=time, values=values)


def _common_times(signals: list[_Mapped], warnings: list[str]) -> tuple[FloatArray, list[FloatArray]]:
    """Interpolate the quantities of one topic at the times of the first; return these times and the values."""
    base = signals[0]
    moved = [signal for signal in signals if not np.array_equal(signal.time, base.time)]
    inside = np.ones(len(base.time), bool)
    for signal in moved:
        if not len(signal.time):
            raise InputError(f"{base.column} and {signal.column} have no time in common; correct the clocks")
        inside &= (base.time >= signal.time[0]) & (base.time <= signal.time[-1])
    time = base.time[inside]
    warnings += [
        f"{signal.entry.quantity} of {signal.entry.component} was interpolated linearly at the times of "
        f"{base.entry.quantity} of {base.entry.component}"
        for signal in moved
        if not np.isin(time, signal.time).all()
    ]
    if len(time) < FEWEST:
        other = moved[0].column if moved else "the position of its motor"
        raise InputError(f"{base.column} and {other} have no time in common; correct the clocks")
    return time, [_between(time, signal) if signal in moved else signal.values[inside] for signal in signals]


def _between(time: FloatArray, signal: _Mapped) -> FloatArray:
    """Interpolate linearly; NaN in long holes, in which nothing is known."""
    values, apart = np.interp(time, signal.time, signal.values), np.diff(signal.time)
    if not len(apart):
        return values
    before = np.clip(np.searchsorted(signal.time, time, side="right") - 1, 0, len(apart) - 1)
    hole = apart[before] > HOLE * np.median(apart)
    inside = hole & (time > signal.time[before]) & (time < signal.time[before + 1])
    return np.where(inside, np.nan, values)


def _stamps(time: FloatArray, zero: float) -> IntArray:
    """Return the stamps of times, of which the first of all columns is `zero` [ns]."""
    return np.asarray(START_NS + np.rint((time - zero) * 1e9).astype(np.int64))


def _tool_series(signals: list[_Mapped], zero: float, warnings: list[str]) -> ImuSeries:
    """Stack the axes of the quantities of the tool; axes that are not mapped are NaN."""
    time, values = _common_times(signals, warnings)
    fields: dict[str, FloatArray] = {}
    for signal, own in zip(signals, values, strict=True):
        field = _FIELDS_OF_TOOL[QUANTITIES[signal.entry.quantity].field]
        fields.setdefault(field, np.full((len(time), 3), np.nan))[:, "xyz".index(signal.entry.component)] = own
    return ImuSeries(_stamps(time, zero), TOOL_FRAME, fields.get("acceleration"), fields.get("turning_rate"))


def _series(signals: list[_Mapped], zero: float, warnings: list[str]) -> JointSeries:
    """Stack the joints of the quantities of one topic; NaN where a joint lacks a quantity that others have."""
    joints = sorted({signal.entry.joint for signal in signals}, key=lambda name: int(name.split("_")[1]))
    time, common = _common_times(signals, warnings)
    fields: dict[str, dict[str, FloatArray]] = defaultdict(dict)
    for signal, own in zip(signals, common, strict=True):
        fields[QUANTITIES[signal.entry.quantity].field][signal.entry.joint] = own
    for signal in signals:
        known = fields[QUANTITIES[signal.entry.quantity].field]
        missing = [joint for joint in joints if joint not in known]
        if missing and QUANTITIES[signal.entry.quantity].drives:
            raise InputError(
                f"the quantity {signal.entry.quantity}, which drives the robot, is mapped for {', '.join(known)} but "
                f"not for {', '.join(missing)}; map it for all joints or for none"
            )
    unknown = np.full(len(time), np.nan)
    stacked: dict[str, Any] = {
        field: np.column_stack([known.get(joint, unknown) for joint in joints]) for field, known in fields.items()
    }
    return JointSeries(_stamps(time, zero), tuple(joints), **stacked)


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
