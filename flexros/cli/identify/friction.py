"""Command that fits friction laws to moves at constant speeds."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.table import Table

from flexros.cli.options import NamespaceOption
from flexros.cli.output import console, print_json, say


def friction(
    logs: list[Path] = typer.Argument(help="Logs of moves with phases of constant speed: folders or .mcap files."),
    joint: str = typer.Option("motor_1", "--joint", help="Motor."),
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Fit the friction laws of equations 3.14 to 3.16 to the torques of a motor at constant speeds."""
    from flexros.identify.friction.laws import LAWS, fit_law
    from flexros.identify.friction.points import constant_speed_points
    from flexros.logs.reader import read_log

    points = constant_speed_points([read_log(log, namespace=namespace or None) for log in logs], joint)
    fits = [fit_law(law, points) for law in LAWS if len(points.speed) > len(law.parameters)]
    best = min(fits, key=lambda fit: fit.criterion) if fits else None
    record = {
        "joint": joint,
        "points": [
            {"speed": float(v), "torque": float(t), "std": float(s)}
            for v, t, s in zip(points.speed, points.torque, points.spread, strict=True)
        ],
        "offset": points.offset,
        "laws": [
            {
                "name": fit.law.name,
                "equation": fit.law.equation,
                "rms": fit.rms,
                "criterion": fit.criterion,
                "parameters": {
                    name: {"value": float(value), "std": float(std)}
                    for name, value, std in zip(fit.law.parameters, fit.values, fit.deviations, strict=True)
                },
            }
            for fit in fits
        ],
        "best": None if best is None else best.law.name,
    }
    if as_json:
        print_json(record)
        return
    table = Table("law", "equation", "rms", "parameters")
    for fit in fits:
        numbers = ", ".join(
            f"{name} {value:.4g} +- {std:.2g}"
            for name, value, std in zip(fit.law.parameters, fit.values, fit.deviations, strict=True)
        )
        table.add_row(fit.law.name, fit.law.equation, f"{fit.rms:.4g}", numbers)
    console.print(table)
    say(f"{len(points.speed)} constant speeds, offset {points.offset:.4g}; best by information: {record['best']}")
