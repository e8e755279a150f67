"""Command that converts a log of another recorder into a rosbag2 log."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer
from rich.table import Table

from flexros.cli.output import console, print_json, progress_bar, say

if TYPE_CHECKING:
    from flexros.logs.time_series import Log, Series

_TOPICS = ("joint_states", "joint_commands", "joint_reference", "link_states", "tool_imu")
_FIELDS = ("position", "velocity", "effort", "acceleration", "turning_rate")


def import_log(
    mapping: str = typer.Argument(help="Built-in mapping (emps), or path of a mapping YAML."),
    file: list[Path] = typer.Argument(
        help="CSV, MATLAB (.mat), NumPy (.npz) files or ROS 2 bags (.mcap, folder) that hold the columns together."
    ),
    out: Path = typer.Option(..., "--out", help="Folder of the log (rosbag2) to write."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Convert a log of another recorder into a rosbag2 log, by a mapping of its columns."""
    from flexros.logs.foreign.import_log import import_log as read_files
    from flexros.logs.foreign.mapping import load_mapping
    from flexros.logs.write_log import write_log

    with progress_bar() as progress:
        task = progress.add_task("reading", total=2)
        log = read_files(load_mapping(mapping), file)
        progress.update(task, description="writing", completed=1)
        write_log(log, out)
    rows = [_figures(name, series) for name in _TOPICS if (series := log.series(name)) is not None]
    if as_json:
        print_json({"log": str(out), "topics": rows, "warnings": list(log.warnings)})
        return
    _print(rows, log)
    say(f"Log: {out}")
    say(f"Analyse it: flexros analyze {shlex.quote(str(out))}")


def _figures(name: str, series: Series) -> dict[str, object]:
    """Return the figures of one topic."""
    interval = np.diff(series.stamp) * 1e-9
    duration = float((series.stamp[-1] - series.stamp[0]) * 1e-9)
    return {
        "topic": name,
        "joints": list(getattr(series, "names", ())),
        "fields": [field for field in _FIELDS if getattr(series, field, None) is not None],
        "samples": len(series.stamp),
        "duration_s": duration,
        "rate_hz": len(interval) / duration,
        "longest_interval_s": float(interval.max()),
    }


def _print(rows: list[dict[str, object]], log: Log) -> None:
    table = Table("topic", "fields", "samples", "time [s]", "rate [Hz]", "longest gap [ms]")
    table.columns[0].no_wrap = True
    for row in rows:
        gap = 1e3 * float(row["longest_interval_s"])  # type: ignore[arg-type]
        fields = ", ".join(row["fields"])  # type: ignore[arg-type]
        cells = f"{row['samples']}", f"{row['duration_s']:.6g}", f"{row['rate_hz']:.6g}", f"{gap:.4g}"
        table.add_row(str(row["topic"]), fields, *cells)
    console.print(table)
    say(f"Joints: {', '.join(log.joint_states.names)}")
    for warning in log.warnings:
        say(f"warning: {warning}")
