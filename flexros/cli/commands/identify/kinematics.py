"""Command that identifies lengths, zeros and compliances from tracker poses, and plans such poses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.model import linear_robot
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working
from flexros.errors import InputError
from flexros.json_text import json_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.kinematics.unknowns import Unknowns

RESULT, ROBOT, PLAN = "kinematics.json", "robot.yaml", "poses.csv"
"""Names of the files of the result."""


def kinematics(
    poses: Path = typer.Argument(None, help="CSV: columns motor_1, ..., x, y, z [m], load [kg]; none with --plan."),
    model: str = typer.Option(..., "--model", help="Nominal robot: built-in name or YAML."),
    out: Path = typer.Option(..., "--out", help="Folder for kinematics.json and robot.yaml, or for poses.csv."),
    validation: Path = typer.Option(None, "--validation", help="CSV of poses that are not fitted."),
    plan: int = typer.Option(0, "--plan", help="Choose this many poses, the most informative ones, instead of a fit."),
    load: list[float] = typer.Option([], "--load", help="With --plan: loads at the tool [kg]; default: 0."),
    noise: float = typer.Option(None, "--noise", help="Tracker noise, rms [m]; default: estimated."),
    length: float = typer.Option(2e-3, "--length", help="Deviation of lengths before the measurement [m]."),
    angle: float = typer.Option(2e-3, "--angle", help="Deviation of zeros and mounting angles [rad]."),
    compliance: float = typer.Option(0.3, "--compliance", help="Relative deviation of stiffnesses [1]."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Identify lengths, angles, encoder zeros and compliances from measured tool positions under load."""
    from flexros.identify.kinematics.unknowns import KinematicPrior, unknowns
    from flexros.identify.report.files import make_folder

    _check(poses, plan, noise)
    unknown = unknowns(linear_robot(model), KinematicPrior(length, angle, compliance))
    record = _planned(unknown, plan, load, noise, out) if plan else None
    if record is None:
        record, text = _fitted(unknown, poses, validation, noise)
        make_folder(out)
        write_result(out / ROBOT, text, "robot")
        write_result(out / RESULT, json_text(record), "result")
    if as_json:
        print_json(record)
    elif plan:
        say(f"{plan} poses: {out / PLAN}; fill in x, y, z as measured at rest")
    else:
        _print(record)
        say(f"Result: {out / RESULT}, robot: {out / ROBOT}")


def _check(poses: Path | None, plan: int, noise: float | None) -> None:
    if (poses is None) == (plan == 0):
        raise InputError("give either a CSV file of measured poses, or --plan with the number of poses to choose")
    if noise is not None and not noise > 0:
        raise InputError(f"--noise is {noise:g} m, but must be positive")


def _planned(unknown: Unknowns, plan: int, loads: list[float], noise: float | None, out: Path) -> dict[str, Any]:
    from flexros.identify.kinematics.design import candidate_poses, optimal_poses
    from flexros.identify.kinematics.record import poses_text
    from flexros.identify.report.files import make_folder

    candidates = candidate_poses(unknown, loads or [0.0])
    with working("choosing poses"):
        chosen = candidates.rows(optimal_poses(unknown, candidates, plan, noise or 1e-4))
    make_folder(out)
    write_result(out / PLAN, poses_text(unknown.robot, chosen), "poses")
    return {"poses": plan, "file": str(out / PLAN)}


def _fitted(unknown: Unknowns, poses: Path, validation: Path | None, noise: float | None) -> tuple[dict[str, Any], str]:
    from flexros.identify.kinematics.fit import fit_kinematics
    from flexros.identify.kinematics.record import read_poses
    from flexros.identify.kinematics.result import kinematic_record

    measured = read_poses(poses, unknown.robot)
    held_out = read_poses(validation, unknown.robot) if validation else None
    with working("fitting"):
        fit = fit_kinematics(unknown, measured, noise)
    return kinematic_record(fit, held_out), fit.robot_text(f"identified from {poses.name}")


def _print(record: Mapping[str, Any]) -> None:
    table = Table("parameter", "nominal", "value", "95 % interval", "unit")
    for row in record["parameters"]:
        if row["determined"]:
            low, high = row["interval"]
            cells = (f"{row['nominal']:.6g}", f"{row['value']:.6g}", f"{low:.6g} to {high:.6g}", row["unit"])
            table.add_row(row["name"], *cells)
    console.print(table)
    left = sum(not row["determined"] for row in record["parameters"])
    say(f"{left} more numbers are hardly determined by the poses and keep their nominal values within the prior.")
    for name in ("fit", "validation"):
        if record[name] is not None:
            before, after = record[name]["before"], record[name]["after"]
            say(
                f"{name.capitalize()}: distance of the tool {before['mean_mm']:.3f} mm on average and "
                f"{before['max_mm']:.3f} mm at most before, {after['mean_mm']:.3f} and {after['max_mm']:.3f} mm after"
            )
