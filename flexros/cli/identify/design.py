"""Command that designs an identification experiment, and what the whole procedure shares with it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Column, Table

from flexros.cli.model import linear_robot
from flexros.cli.output import console, print_json, progress_bar, say
from flexros.cli.run import key_and_value
from flexros.errors import InputError, unknown_name
from flexros.whole_file import write_result

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.robot import Robot
    from flexros.scenario.scenario import Scenario

POSITIONS = 15
"""Positions by default, as in Moberg (2007), Paper A; fewer for robots with fewer unknown parameters."""
UNKNOWN = (
    "Parameter to identify (may be repeated); replaces the default: the list of the robot file, else all its springs "
    "and dampers."
)
RANGE = "Of a gear, e.g. motor_1=-0.5:0.5 (may be repeated); default: 1 rad or 0.2 m either side of the home pose."
"""Helps of options."""
_LISTED = "(others are named alike, e.g. body_1.mass, body_2.center_of_mass.x, motor_1.inertia)"
_SMALLEST = "std: with optimal weights and noise alone; the weights of a fit by default (combined) reach larger ones"


def design(
    name: str = typer.Argument(help="Robot: shipped name or YAML.", metavar="ROBOT"),
    out: Path = typer.Option(
        ..., "--out", help="Scenario of the experiment to write (YAML); one that exists is replaced."
    ),
    positions: int = typer.Option(0, "--positions", help="Number of positions; default: 15, or as many as unknowns."),
    candidates: int = typer.Option(4000, "--candidates", help="Number of positions to choose from."),
    ranges: list[str] = typer.Option([], "--range", help=RANGE),
    repeat: bool = typer.Option(False, "--repeat", help="Allow a position to be chosen more than once."),
    distortion: float = typer.Option(0.0, "--distortion", help="Expected nonlinear share of the output, e.g. 0.01."),
    minutes: float = typer.Option(30.0, "--minutes", help="Robot time up to which transient periods are added."),
    scenario: str = typer.Option("", "--scenario", help="Excitation and controller; default: chosen for the robot."),
    setting: list[str] = typer.Option([], "--set", help="Key of the scenario, e.g. identification.blocks=3."),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    seed: int = typer.Option(1, "--seed", help="Seed of candidates and excitation."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Choose the positions that tell most about the unknown parameters, and write the scenario."""
    from flexros.identify.design.experiment_design import DesignSettings
    from flexros.scenario.identification_plan import plan_of_scenario

    checked_minutes(minutes)
    if not 0 <= distortion <= 1:
        raise InputError(f"--distortion is {distortion:g}, but must be a share of the output from 0 to 1, e.g. 0.01")
    robot = linear_robot(name)
    names = chosen_names(robot, unknown)
    template = template_with(name, robot, scenario, [*setting, f"seed={seed}"])
    settings = DesignSettings(
        positions=positions or min(POSITIONS, len(names)),
        candidates=candidates,
        most=None if repeat else 1,
        distortion=distortion,
        seed=template.seed,
    )
    found, experiment, factor = designed(robot, names, template, settings, gear_ranges(robot, ranges), out, minutes)
    duration = plan_of_scenario(experiment).duration
    if as_json:
        print_json(design_record(found, factor, duration))
        return
    print_design(found, factor, duration)
    say(f"Scenario: {out}; run it: flexros run {out} --out log, then: flexros identify frf log --out frf.nc")


def checked_minutes(minutes: float) -> None:
    """Check the robot time up to which transient periods are added.

    Args:
        minutes: What was given [min].

    Raises:
        InputError: It is no length of time.
    """
    if not (math.isfinite(minutes) and minutes >= 0):
        raise InputError(
            f"--minutes is {minutes:g}, but must be a finite number of 0 or more; transient periods are added up to "
            "this robot time"
        )


def chosen_names(robot: Robot, given: list[str]) -> tuple[str, ...]:
    """Take the unknown parameters that were given, else those of the robot.

    Args:
        robot: The robot.
        given: Names from the command line.

    Returns:
        The names.

    Raises:
        InputError: A name is not a parameter of the robot, or there is none.
    """
    from flexros.scenario.identification import unknown_names

    for name in given:
        if name not in robot.parameters:
            raise unknown_name(f"parameter of robot {robot.name}", name, robot.parameters, "--unknown", _LISTED)
    return tuple(dict.fromkeys(given)) or unknown_names(robot)


def template_with(
    reference: str, robot: Robot, scenario: str, settings: list[str], effects: list[str] | None = None
) -> Scenario:
    """Load the template of the experiment and apply the options of the command line.

    Args:
        reference: Shipped name or file of the robot.
        robot: The robot.
        scenario: Template; empty for the robot's own.
        settings: Changes as key=value.
        effects: Effects of the plant.

    Returns:
        The scenario, its positions still to be chosen.

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
    """Read ranges of gears, MOTOR=LOW:HIGH; those that are not given lie about the home pose.

    Args:
        robot: The robot.
        texts: What was given.

    Returns:
        Smallest and largest coordinate of each gear [rad or m], shape (M, 2).

    Raises:
        InputError: No such motor, or no two numbers in order.
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


def designed(
    robot: Robot,
    names: tuple[str, ...],
    template: Scenario,
    settings: Any,
    ranges: FloatArray,
    out: Path,
    minutes: float,
) -> tuple[ExperimentDesign, Scenario, float]:
    """Design the experiment with a progress bar and write its scenario.

    Args:
        robot: The robot with its nominal values.
        names: Unknown parameters.
        template: Excitation and controller.
        settings: `DesignSettings`.
        ranges: Ranges of the gears [rad or m], shape (M, 2).
        out: File of the scenario.
        minutes: Longest experiment to which transient periods are added [min].

    Returns:
        The design, the scenario as it was written, and the factor by which amplitudes were lowered.

    Raises:
        InputError: Something is not possible, or the file cannot be written.
    """
    from flexros.identify.design.experiment_design import design_experiment
    from flexros.scenario.identification import designed_scenario, scenario_yaml
    from flexros.scenario.scenario import load_scenario

    assert template.identification is not None
    sample_time = robot.sample_time if template.sample_time is None else template.sample_time
    with progress_bar() as bar:
        tasks: dict[str, Any] = {}

        def tell(what: str, done: int, whole: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=whole)
            bar.update(tasks[what], completed=done)

        found = design_experiment(
            robot, names, template.identification, template.controller, sample_time, settings, ranges, tell
        )
    experiment, factor = designed_scenario(template, robot, found, 60 * minutes)
    write_result(out, scenario_yaml(experiment), "scenario")
    return found, load_scenario(out), factor


def design_record(found: ExperimentDesign, factor: float, duration: float) -> dict[str, Any]:
    """Give the figures of a design for JSON; times in seconds, deviations relative."""
    return {
        "positions": found.positions.tolist(),
        "shares": found.counts.tolist(),
        "candidates": len(found.candidates.gears),
        "origin": found.origin,
        "remark": found.remark,
        "refused": dict(found.candidates.refused),
        "duality_gap": found.design.gap,
        "optimal_support": len(found.design.support),
        "efficiency": found.gain.efficiency,
        "random_efficiency": {
            "median": float(found.gain.random_efficiency[len(found.gain.random_efficiency) // 2]),
            "best": float(found.gain.random_efficiency[-1]),
        },
        "relative_std_of": _SMALLEST,
        "relative_std": dict(zip(found.names, found.gain.deviation.tolist(), strict=True)),
        "random_relative_std": dict(zip(found.names, found.gain.random_deviation.tolist(), strict=True)),
        "amplitude_factor": factor,
        "duration_s": duration,
    }


def print_design(found: ExperimentDesign, factor: float, duration: float) -> None:
    """Print a design for people."""
    table = Table(Column("parameter", no_wrap=True), "smallest std [%]", "random positions [%]", caption=_SMALLEST)
    rows = zip(found.names, found.gain.deviation, found.gain.random_deviation, strict=True)
    for name, deviation, other in rows:
        table.add_row(name, f"{100 * deviation:.3g}", f"{100 * other:.3g}")
    console.print(table)
    record = design_record(found, factor, duration)
    say(
        f"{len(found.chosen)} positions chosen out of {found.origin}; {duration / 60:.3g} min of robot time: "
        f"{100 * record['efficiency']:.3g} % of the best shares (duality gap {record['duality_gap']:.1g}), random ones "
        f"{100 * record['random_efficiency']['median']:.3g} %, at best "
        f"{100 * record['random_efficiency']['best']:.3g} %"
    )
    if found.remark:
        say(found.remark)
    if factor < 1:
        say(f"Amplitudes were lowered to {100 * factor:.3g} % of what the template says, because of the torque limits.")
