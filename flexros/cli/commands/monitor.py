"""Command that replays a log to the gap monitor, or calibrates the thresholds of the monitor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from flexros.cli.commands.diagnose import GAP_FOUND
from flexros.cli.options import KnownModelOption, NamespaceOption
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.monitor.gap_monitor import GapMonitor
    from flexros.monitor.watch_log import WatchedLog


def monitor(
    bag: Annotated[Path, typer.Argument(help="Log folder (rosbag2), .mcap or .db3 file.")],
    model: KnownModelOption,
    thresholds: Path | None = typer.Option(
        None, "--thresholds", help="File written by --calibrate; default: thresholds of the noise alone."
    ),
    calibrate: Path | None = typer.Option(
        None, "--calibrate", help="Accept the log as reference: write thresholds to this file."
    ),
    false_alarms: float = typer.Option(1e-3, "--false-alarms", help="Rate of false alarms of the whole robot [1/h]."),
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> int:
    """Run the gap monitor on a log as its node does online; the exit code is 1 after an alarm."""
    from flexros.effects.patching.patched_robot import load_patched
    from flexros.logs.reader import read_log
    from flexros.monitor.calibration import read_calibration
    from flexros.monitor.gap_monitor import GapMonitor
    from flexros.monitor.watch_log import watch_log

    if not 1e-6 <= false_alarms <= 100:
        raise InputError(f"--false-alarms is {false_alarms:g}, allowed are rates from 1e-6 to 100 per hour")
    if calibrate is not None and thresholds is not None:
        raise InputError("--thresholds and --calibrate exclude each other: thresholds are either read or written")
    known = load_patched(model)
    names = known.base.joint_names
    limits = None if thresholds is None else read_calibration(thresholds, known.fingerprint, names)
    log = read_log(bag, namespace=namespace or None)
    watching = GapMonitor(known.model, false_alarms=false_alarms, calibration=limits)
    with progress_bar() as bar:
        task = bar.add_task("watching", total=None)
        watched = watch_log(
            log, watching, name=bag.name, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    for warning in (*log.warnings, *watched.warnings):
        typer.echo(f"flexros: {warning}", err=True)
    if calibrate is not None:
        return _calibrate(calibrate, watched, names, model=known.fingerprint, robot=known.base.name, log=bag.name)
    if as_json:
        print_json(_content(watching, watched))
    else:
        _print(bag, watching, watched)
    return GAP_FOUND if watched.episodes else 0


def _calibrate(path: Path, watched: WatchedLog, names: tuple[str, ...], **of: str) -> int:
    from flexros.monitor.calibration import calibrate, write_calibration

    made = calibrate(watched.values, watched.motion, names, **of)
    write_calibration(path, made)
    accepted = ", ".join(f"{name} {value:.3g}" for name, value in made.accepted.items())
    say(f"{path}: thresholds by {made.time:.1f} s; accepted gap, over noise: {accepted}")
    return 0


def _content(watching: GapMonitor, watched: WatchedLog) -> dict[str, Any]:
    from flexros.monitor.statement import motor_values, robot_sentence, robot_values

    reading = watched.reading
    return {
        "message": robot_sentence(reading),
        **robot_values(reading),
        "alarms": [
            {
                "since_s": episode.since * 1e-9,
                "told_s": episode.stamp * 1e-9,
                "message": episode.sentence,
                "joint": episode.joint,
                "kind": episode.kind,
            }
            for episode in watched.episodes
        ],
        "motors": {motor.name: motor_values(motor) for motor in reading.motors},
        "windows": watching.windows,
        "settling_windows": watching.settled,
        **vars(watching.counts),
    }


def _print(bag: Path, watching: GapMonitor, watched: WatchedLog) -> None:
    from flexros.monitor.statement import torque_units

    for episode in watched.episodes:
        say(episode.sentence)
    if not watched.episodes:
        say(f"no alarm in {watching.windows * 0.1:.1f} s of {bag.name}")
    table = Table("motor", "gap, last second", "disturbance torque, rms", "noise floor", "share of alarm")
    units = torque_units(watching.robot)
    for motor, unit in zip(watched.reading.motors, units):
        table.add_row(
            motor.name,
            f"{motor.gap:.3g}",
            f"{motor.torque[1]:.3g} {unit}",
            f"{motor.torque_floor:.3g} {unit}",
            f"{100 * motor.alarm.share:.3g} %",
        )
    console.print(table)
