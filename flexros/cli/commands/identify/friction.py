"""Command that fits friction laws to moves at constant speeds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.model import ROBOT, robot_of_run
from flexros.cli.options import NamespaceOption
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working

if TYPE_CHECKING:
    from flexros.identify.friction.measurement import FrictionMeasurement
    from flexros.logs.time_series import Log


def friction(
    logs: list[Path] = typer.Argument(
        help="Logs of moves with phases of constant speed: folders, .mcap or .db3 files."
    ),
    joint: str = typer.Option("motor_1", "--joint", help="Motor."),
    model: str = typer.Option("", "--model", help=f"{ROBOT} Gives the units; default: from the provenance."),
    namespace: NamespaceOption = "",
    report: Path = typer.Option(None, "--report", help="Write an HTML report that opens offline."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Fit the friction laws of equations 3.14 to 3.16 to the torques of a motor at constant speeds."""
    from flexros.identify.friction.measurement import measure_friction
    from flexros.identify.friction.report import friction_report
    from flexros.logs.reader import read_log

    with working("fitting friction laws"):
        read = [read_log(log, namespace=namespace or None) for log in logs]
        measured = measure_friction(read, joint, linear=_linear(model, read[0], joint))
    if report is not None:
        write_result(report, friction_report(measured, [str(log) for log in logs]), "report")
    if as_json:
        print_json(measured.record())
        return
    _print(measured)
    if report is not None:
        say(f"report: {report}")


def _linear(model: str, log: Log, joint: str) -> bool:
    robot = robot_of_run(model, log)
    motors = () if robot is None else robot.motors
    return any(motor.name == joint and not motor.rotary for motor in motors)


def _print(measured: FrictionMeasurement) -> None:
    table = Table("law", "equation", f"rms [{measured.torque_unit}]", "parameters")
    for fit in measured.fits:
        numbers = ", ".join(
            f"{name} {value:.4g} +- {std:.2g}"
            for name, value, std in zip(fit.law.parameters, fit.values, fit.deviations, strict=True)
        )
        table.add_row(fit.law.name, fit.law.equation, f"{fit.rms:.4g}", numbers)
    console.print(table)
    best = "no law, too few speeds" if measured.best is None else measured.best.law.name
    count, offset = len(measured.points.speed), measured.points.offset
    say(f"{count} constant speeds, offset {offset:.4g} {measured.torque_unit}; best by information: {best}")
