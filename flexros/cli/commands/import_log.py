"""Command that converts a log of another recorder into a rosbag2 log."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.output import console, print_json, say, suggest
from flexros.cli.progress import progress_bar, progress_shown
from flexros.errors import InputError
from flexros.logs.foreign.signal_source import BAG_SUFFIXES, ROS_1, open_source

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.logs.time_series import Log, Series
    from flexros.record.proposal.assumption import Assumption
    from flexros.robot import Robot

_TOPICS = ("joint_states", "joint_commands", "joint_reference", "link_states", "tool_imu")
_MAPPINGS = (".yaml", ".yml")
_DESCRIPTIONS = (".urdf", ".xml")
_FIELDS = ("position", "velocity", "effort", "acceleration", "turning_rate")


def import_log(
    mapping: str = typer.Argument(
        help="Mapping YAML or built-in mapping (emps); or a log alone, to propose its mapping: a ROS 2 bag (folder, "
        ".mcap or .db3), or a table whose names tell what its columns are (time, q1, tau1, elbow_position).",
        metavar="MAPPING|LOG",
    ),
    file: list[Path] = typer.Argument(
        None,
        help="CSV, MATLAB (.mat), NumPy (.npz), JSON files or ROS 2 bags that hold the columns of MAPPING together.",
    ),
    out: Path = typer.Option(
        None, "--out", help="Folder of the log (rosbag2) to write; without it the mapping of a LOG is proposed alone."
    ),
    model: str = typer.Option(
        "",
        "--model",
        help="Robot YAML, built-in robot, patch or URDF whose joints LOG has; default: the URDF on its topic "
        "robot_description.",
    ),
    proposed: Path = typer.Option(
        None,
        "--mapping",
        help="Mapping YAML to write for a LOG; default: OUT, else the name of LOG, with _mapping.yaml.",
    ),
    rate: float = typer.Option(None, "--rate", help="Rows per second of a LOG that is a table without times [Hz]."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Convert a log of another recorder into a rosbag2 log, by a mapping of its columns or one proposed for it."""
    from flexros.logs.foreign.import_log import import_log as read_files
    from flexros.logs.foreign.mapping import load_mapping
    from flexros.logs.write_log import write_log

    if not file and (_is_bag(mapping) or _is_table(mapping)):
        _propose(Path(mapping), model, out, proposed, rate, as_json)
        return
    _refuse_what_logs_need(mapping, file, out, model, proposed, rate)
    with progress_bar() as progress:
        task = progress.add_task("reading", total=2)
        log = read_files(load_mapping(mapping), file)
        progress.update(task, description="writing", completed=1)
        write_log(log, out)
    rows = _rows(log)
    if as_json:
        print_json({"log": str(out), "topics": rows, "warnings": list(log.warnings)})
        return
    _print(rows, log)
    say(f"Log: {out}")
    if _drives(log):
        suggest(f"flexros gap {shlex.quote(str(out))} --model ROBOT    how far robot and model are apart")
    else:
        suggest(f"flexros analyze {shlex.quote(str(out))}    tracking and timing")


def _is_bag(name: str) -> bool:
    """Whether an argument is a bag and no mapping."""
    return Path(name).suffix in BAG_SUFFIXES or Path(name).is_dir()


def _is_table(name: str) -> bool:
    """Whether an argument is a file of columns and no mapping."""
    path = Path(name)
    return path.is_file() and path.suffix not in (*_MAPPINGS, ROS_1)


def _refuse_what_logs_need(
    mapping: str, file: list[Path], out: Path, model: str, proposed: Path, rate: float | None
) -> None:
    """Refuse arguments that do not go with a mapping of the user."""
    if not file:
        if Path(mapping).suffix not in ("", *_MAPPINGS):
            open_source(Path(mapping))  # refuses a file that is not there or not read, with what to do
        raise InputError(f"{mapping} is given without files; give the files that hold its columns, or a log alone")
    if out is None:
        raise InputError("no folder of the log is given; name a new one", "out")
    if _is_bag(mapping) or _is_table(mapping):
        raise InputError(f"{mapping} is a log; give one log alone, or a mapping and its files")
    for value, argument in ((model, "model"), (proposed, "proposed"), (rate, "rate")):
        if value:
            raise InputError(f"{value}: only the mapping of a log is proposed, and {mapping} is a mapping", argument)


def _propose(bag: Path, model: str, out: Path | None, proposed: Path | None, rate: float | None, as_json: bool) -> None:
    """Propose the mapping of a bag, write it, and the log with a folder for it."""
    from flexros.logs.write_log import write_log
    from flexros.record.proposal.propose import propose_mapping, robot_in_bag
    from flexros.record.proposal.text import mapping_text

    path = proposed or Path(f"{out or bag.stem}_mapping.yaml")
    if out is not None and out.exists():
        raise InputError(f"{out} exists already; give another name or remove it")
    with progress_shown() as show:
        show("robot", 0.0)
        robot, assumed = _robot(model) if model else (robot_in_bag(bag), [])
        show("reading", 0.1)
        found = propose_mapping(bag, robot, lambda text: show(text, 0.5), rate=rate)
        assumed += found.assumptions
        text = mapping_text(found.mapping, assumed)
        if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
            again = f"flexros import {shlex.quote(str(path))} {shlex.quote(str(bag))} --out LOG"
            raise InputError(
                f"{path} exists already and says something else than the mapping that is proposed; to import the log "
                f"by it: {again}; to propose one, give another name or remove it"
            )
        if out is not None:
            show("writing", 0.9)
            write_log(found.log, out)
        write_result(path, text, "mapping")
    rows = _rows(found.log)
    if as_json:
        log = None if out is None else str(out)
        warnings = list(found.log.warnings)
        told = [asdict(each) for each in assumed]
        print_json({"log": log, "mapping": str(path), "assumptions": told, "topics": rows, "warnings": warnings})
        return
    _print_assumptions(assumed)
    if out is not None:
        _print(rows, found.log)
    say(f"Mapping: {path}")
    if out is None:
        suggest(f"correct what is wrong in the mapping, then flexros import {path} {bag} --out LOG")
        return
    say(f"Log: {out}")
    if not _drives(found.log):
        again = f"flexros import {path} {bag} --out LOG"
        suggest(f"map what drives the robot, torques or commanded positions, by hand, then {again}")
    elif robot is not None and model and not model.endswith(_DESCRIPTIONS):
        suggest(f"flexros gap {shlex.quote(str(out))} --model {shlex.quote(model)}    how far they are apart")
    else:
        suggest(f"flexros analyze {shlex.quote(str(out))}    tracking and timing")


def _drives(log: Log) -> bool:
    """Return whether a log has torques or commanded positions, without which nothing can be predicted."""
    series = (log.joint_states, log.joint_commands)
    commanded = log.joint_commands is not None and log.joint_commands.position is not None
    return commanded or any(one is not None and one.effort is not None for one in series)


def _robot(model: str) -> tuple[Robot, list[Assumption]]:
    """Load a robot, or make one from a URDF; return it and what was assumed of the URDF."""
    from flexros.config.yaml_file import parse_yaml
    from flexros.effects.patching.patched_robot import load_model
    from flexros.record.proposal.assumption import Assumption
    from flexros.robot import robot_from_data
    from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

    if model.endswith(_DESCRIPTIONS):
        imported = robot_from_urdf(Path(model))
        assumed = [Assumption("robot", note, f"joints of {model}", True) for note in imported.notes]
        return robot_from_data(parse_yaml(imported.text, model), model), assumed
    return load_model(model).robot, []


def _print_assumptions(assumptions: Sequence[Assumption]) -> None:
    table = Table("about", "assumed", "on what ground", title="Assumptions", title_justify="left")
    table.columns[0].no_wrap = True
    for each in assumptions:
        table.add_row(each.about, each.taken, each.ground if each.checked else f"NOT CHECKED: {each.ground}")
    console.print(table)


def _rows(log: Log) -> list[dict[str, object]]:
    return [_figures(name, series) for name in _TOPICS if (series := log.series(name)) is not None]


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
    from flexros.gap.settings import NoiseSettings

    table = Table("topic", "fields", "samples", "time [s]", "rate [Hz]", "longest gap [ms]")
    table.columns[0].no_wrap = True
    for row in rows:
        gap = 1e3 * float(row["longest_interval_s"])  # type: ignore[arg-type]
        fields = ", ".join(row["fields"])  # type: ignore[arg-type]
        cells = f"{row['samples']}", f"{row['duration_s']:.6g}", f"{row['rate_hz']:.6g}", f"{gap:.4g}"
        table.add_row(str(row["topic"]), fields, *cells)
    console.print(table)
    say(f"Joints: {', '.join(log.joint_states.names)}")
    if any("effort" in row["fields"] for row in rows):  # type: ignore[operator]
        share = NoiseSettings().signal_tolerance
        say(f"Torques count as known within {share:.0%} of their rms; those of a simulator: --tolerance torque=0.005")
    for warning in log.warnings:
        say(f"warning: {warning}")
