"""Command that designs an identification experiment, and the options that the whole procedure shares with it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Column, Table

from flexros.cli.commands.run import key_and_value
from flexros.cli.model import linear_robot
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.scenario.identification import DesignedExperiment
    from flexros.scenario.scenario import Scenario

UNKNOWN = (
    "Parameter to identify (may be repeated); replaces the default: the list of the robot file, else all its springs "
    "and dampers."
)
RANGE = "Of a gear, e.g. motor_1=-0.5:0.5 (may be repeated); default: 1 rad or 0.2 m either side of the home pose."
"""Helps of options."""
_SMALLEST = "std: with optimal weights and noise alone; the weights of a fit by default (combined) reach larger ones"


def design(
    name: str = typer.Argument(help="Nominal robot: built-in name or YAML.", metavar="ROBOT"),
    out: Path = typer.Option(
        ..., "--out", help="Scenario of the experiment to write (YAML); one that exists is replaced."
    ),
    positions: int = typer.Option(0, "--positions", help="Number of positions; default: 15, or as many as unknowns."),
    candidates: int = typer.Option(4000, "--candidates", help="Number of positions to choose from."),
    ranges: list[str] = typer.Option([], "--range", help=RANGE),
    repeat: bool = typer.Option(False, "--repeat", help="Allow a position to be chosen more than once."),
    distortion: float = typer.Option(
        0.0, "--distortion", help="Expected nonlinear share of the output, e.g. 0.01 [1]."
    ),
    minutes: float = typer.Option(30.0, "--minutes", help="Robot time up to which transient periods are added [min]."),
    scenario: str = typer.Option("", "--scenario", help="Excitation and controller; default: chosen for the robot."),
    setting: list[str] = typer.Option([], "--set", help="Key of the scenario, e.g. identification.blocks=3."),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    seed: int = typer.Option(1, "--seed", help="Seed of candidates and excitation."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Choose the most informative positions for the unknown parameters, and write the scenario."""
    from flexros.identify.design.experiment_design import DesignSettings, default_positions
    from flexros.scenario.identification import design_identification, unknown_names

    checked_minutes(minutes)
    if not 0 <= distortion <= 1:
        raise InputError(f"--distortion is {distortion:g}, but must be a share of the output from 0 to 1, e.g. 0.01")
    robot = linear_robot(name)
    names = unknown_names(robot, unknown)
    template = template_with(name, robot, scenario, [*setting, f"seed={seed}"])
    settings = DesignSettings(
        positions=positions or default_positions(len(names)),
        candidates=candidates,
        most=None if repeat else 1,
        distortion=distortion,
        seed=template.seed,
    )
    with progress_bar() as bar:
        tasks: dict[str, Any] = {}

        def report(step: str, done: int, total: int) -> None:
            if step not in tasks:
                tasks[step] = bar.add_task(step, total=total)
            bar.update(tasks[step], completed=done)

        experiment = design_identification(
            robot, names, template, out, settings=settings, ranges=gear_ranges(robot, ranges), longest=60 * minutes,
            progress=report,
        )  # fmt: skip
    if as_json:
        print_json(design_record(experiment))
        return
    print_design(experiment)
    say(f"Scenario: {out}")


def checked_minutes(minutes: float) -> None:
    """Check the robot time up to which transient periods are added.

    Args:
        minutes: Robot time [min].

    Raises:
        InputError: It is negative or not finite.
    """
    if not (math.isfinite(minutes) and minutes >= 0):
        raise InputError(
            f"--minutes is {minutes:g}, but must be a finite number of 0 or more; transient periods are added up to "
            "this robot time"
        )


def template_with(
    reference: str, robot: Robot, scenario: str, settings: list[str], effects: list[str] | None = None
) -> Scenario:
    """Load the template of the experiment and apply the options of the command line to it.

    Args:
        reference: Built-in name or file of the robot.
        robot: The robot.
        scenario: Template; empty for the robot's own.
        settings: Changes as key=value.
        effects: Effects of the plant, after those of the template.

    Returns:
        The scenario; its positions are still to be chosen.

    Raises:
        InputError: Something is unknown or not allowed.
    """
    from flexros.scenario.identification import template_scenario

    absolute = str(Path(reference).resolve()) if Path(reference).suffix in (".yaml", ".yml") else reference
    template = template_scenario(robot, absolute, scenario)
    changes = dict(key_and_value(text, "--set") for text in settings)
    template = template.with_values(changes, "command line")
    if effects:
        template = template.with_values({"plant.effects": [*template.plant.effects, *effects]}, "--effect")
    return template


def gear_ranges(robot: Robot, texts: list[str]) -> FloatArray:
    """Parse ranges of gears, MOTOR=LOW:HIGH; the default is a range about the home pose.

    Args:
        robot: The robot.
        texts: The values of the option.

    Returns:
        Smallest and largest coordinate of each gear [rad or m], shape (M, 2).

    Raises:
        InputError: Unknown motor, or not two numbers in ascending order.
    """
    from flexros.identify.design.candidates import default_ranges

    ranges = default_ranges(robot)
    for text in texts:
        motor, _, pair = text.partition("=")
        if motor not in robot.joint_names:
            raise unknown_name(f"motor of robot {robot.name}", motor, robot.joint_names, "--range")
        try:
            low, high = (float(part) for part in pair.split(":"))
        except ValueError:
            low, high = 1.0, 0.0
        if not low <= high:
            raise InputError(f"--range is '{text}', but must be MOTOR=LOW:HIGH, e.g. motor_1=-0.5:0.5 [rad or m]")
        ranges[robot.joint_names.index(motor)] = low, high
    return ranges


def design_record(experiment: DesignedExperiment) -> dict[str, Any]:
    """Return the figures of a design for JSON; times in seconds, deviations relative."""
    design = experiment.design
    random = design.gain.random_efficiency
    return {
        "positions": design.positions.tolist(),
        "shares": design.counts.tolist(),
        "candidates": len(design.candidates.gears),
        "origin": design.origin,
        "remark": design.remark,
        "refused": dict(design.candidates.refused),
        "duality_gap": design.design.gap,
        "optimal_support": len(design.design.support),
        "efficiency": design.gain.efficiency,
        "random_efficiency": {"median": float(random[len(random) // 2]), "best": float(random[-1])},
        "relative_std_of": _SMALLEST,
        "relative_std": dict(zip(design.names, design.gain.deviation.tolist(), strict=True)),
        "random_relative_std": dict(zip(design.names, design.gain.random_deviation.tolist(), strict=True)),
        "amplitude_factor": experiment.amplitude_factor,
        "duration_s": experiment.duration,
    }


def print_design(experiment: DesignedExperiment) -> None:
    """Print a design for people."""
    design, factor = experiment.design, experiment.amplitude_factor
    table = Table(Column("parameter", no_wrap=True), "smallest std [%]", "random positions [%]", caption=_SMALLEST)
    for name, deviation, random in zip(design.names, design.gain.deviation, design.gain.random_deviation, strict=True):
        table.add_row(name, f"{100 * deviation:.3g}", f"{100 * random:.3g}")
    console.print(table)
    record = design_record(experiment)
    say(
        f"{len(design.chosen)} positions chosen out of {design.origin}; {experiment.duration / 60:.3g} min of robot "
        f"time: {100 * record['efficiency']:.3g} % of the best shares (duality gap {record['duality_gap']:.1g}), "
        f"random ones {100 * record['random_efficiency']['median']:.3g} %, at best "
        f"{100 * record['random_efficiency']['best']:.3g} %"
    )
    if design.remark:
        say(design.remark)
    if factor < 1:
        say(f"Amplitudes were lowered to {100 * factor:.3g} % of the template's because of the torque limits.")
