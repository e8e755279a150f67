"""Commands that identify a robot: the whole procedure, and its steps one by one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flexros.cli.commands.identify import axis as identify_axis
from flexros.cli.commands.identify import friction as identify_friction
from flexros.cli.commands.identify import kinematics as identify_kinematics
from flexros.cli.commands.identify import rigid as identify_rigid
from flexros.cli.commands.identify.design import RANGE, UNKNOWN, checked_minutes, design, gear_ranges, template_with
from flexros.cli.commands.identify.fit import BOUND, fit, print_identification, value_bounds
from flexros.cli.commands.identify.frf import frf
from flexros.cli.commands.run import choose_transport, run_direct
from flexros.cli.model import linear_robot
from flexros.cli.output import print_json, say
from flexros.cli.progress import progress_bar, working
from flexros.errors import InputError, unknown_name
from flexros.scenario import transports

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.progress import Progress

    from flexros.scenario.identification import DesignedExperiment
    from flexros.scenario.transports import RunResult

LAYOUTS = ("composed", "processes")
"""Layouts of the nodes."""

OUT = "Folder for scenario, log, responses, identified robot and report; a folder with a log is refused."
REAL = (
    "Robot YAML that plays the real one; default: ROBOT itself. It may differ in parameters of the equations of "
    "motion; other structures, sensors and limits are refused."
)
"""Helps of options."""


def robot(
    name: str = typer.Argument(help="Nominal robot: built-in name or YAML.", metavar="ROBOT"),
    out: Path = typer.Option(..., "--out", help=OUT),
    positions: int = typer.Option(0, "--positions", help="Number of positions; default: 15, or as many as unknowns."),
    candidates: int = typer.Option(4000, "--candidates", help="Number of positions to choose from."),
    ranges: list[str] = typer.Option([], "--range", help=RANGE),
    minutes: float = typer.Option(30.0, "--minutes", help="Robot time up to which transient periods are added [min]."),
    scenario: str = typer.Option("", "--scenario", help="Excitation and controller; default: chosen for the robot."),
    real: str = typer.Option("", "--real", help=REAL),
    effect: list[str] = typer.Option(
        [], "--effect", help="Effect in the plant, NAME@LOCATION:parameter=value,... (may be repeated)."
    ),
    setting: list[str] = typer.Option(
        [], "--set", help="Key of the scenario, e.g. plant.values.body_3.mass=290 or identification.blocks=3."
    ),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    estimator: str = typer.Option("LLS", "--estimator", help="LLS, LLSM (magnitude only) or NLS."),
    weights: str = typer.Option("combined", "--weights", help="Of the last fit: user, optimal or combined."),
    starts: int = typer.Option(20, "--starts", help="Number of initial values, the first are the nominal ones."),
    bound: list[str] = typer.Option([], "--bound", help=BOUND),
    transport: str = typer.Option("", "--transport", help="ros or direct; default: ros where it is installed."),
    layout: str = typer.Option("composed", "--layout", help="Of the nodes: composed or processes."),
    seed: int = typer.Option(1, "--seed", help="Seed of candidates, excitation, noise and initial values."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Design an experiment, run it, estimate frequency responses, fit the parameters, and report."""
    from flexros.identify.design.experiment_design import DesignSettings, default_positions
    from flexros.identify.graybox.search import SearchSettings
    from flexros.scenario.identification import unknown_names, with_real_robot
    from flexros.scenario.identification_procedure import LOG, identify_robot

    if (out / LOG).exists():
        raise InputError(_log_exists(out / LOG, name))
    checked_minutes(minutes)
    if layout not in LAYOUTS:
        raise unknown_name("layout", layout, LAYOUTS, "--layout")
    nominal = linear_robot(name)
    names = unknown_names(nominal, unknown)
    settings = SearchSettings(estimator, weights, starts, seed, value_bounds(bound))
    settings.check(nominal, names)
    template = template_with(name, nominal, scenario, [*setting, f"seed={seed}"], effect)
    if real:
        template = with_real_robot(template, nominal, linear_robot(real))
    transport = choose_transport(transport, quiet=as_json)
    with progress_bar() as bar:
        identification = identify_robot(
            nominal,
            template,
            out,
            lambda experiment, log: _run(experiment, log, transport, layout, bar, quiet=as_json),
            unknown=names,
            design=DesignSettings(positions or default_positions(len(names)), candidates, seed=seed),
            ranges=gear_ranges(nominal, ranges),
            longest=60 * minutes,
            settings=settings,
            progress=_shown(bar),
        )
    if as_json:
        print_json(identification.as_dict())
        return
    print_identification(identification.result, out)
    say(f"Robot time: {identification.experiment.duration / 60:.3g} min")


def _run(
    experiment: DesignedExperiment, log: Path, transport: str, layout: str, bar: Progress, *, quiet: bool
) -> RunResult:
    """Run the designed experiment, after its robot time was printed."""
    if not quiet:
        positions = len(experiment.design.positions)
        minutes = experiment.duration / 60
        say(f"Experiment in {positions} position{'s' * (positions != 1)}: {minutes:.3g} min of robot time")
    _announce("running the experiment")
    bar.stop()  # the run has its own
    try:
        if transport == "direct":
            return run_direct(experiment.scenario, log)
        with working("running over topics"):
            return transports.run_ros(experiment.scenario, log, layout)
    finally:
        bar.start()


def _shown(bar: Progress) -> Callable[[str, int, int], None]:
    """Show the steps of the procedure in a progress bar, or where there is none by a line at the start of each."""
    from flexros.scenario.identification_procedure import FIT

    tasks: dict[str, Any] = {}

    def report(step: str, done: int, total: int) -> None:
        if step not in tasks:
            tasks[step] = bar.add_task(step, total=total)
            _announce(f"fitting from {total} start{'s' * (total != 1)}" if step == FIT else step)
        bar.update(tasks[step], completed=done, total=total)

    return report


def _announce(step: str) -> None:
    """Print the step that starts, where no progress bar shows it."""
    if not sys.stderr.isatty():
        typer.echo(f"flexros: {step}", err=True)


def _log_exists(log: Path, name: str) -> str:
    """Word the error of an experiment that was run already, with the commands that continue it."""
    responses, fitted = log.parent / "frf.nc", log.parent / "fit"
    return (
        f"the log folder {log} exists already; give another folder with --out, or go on with this log: flexros "
        f"identify frf {log} --out {responses}; flexros identify fit {responses} --model {name} --out {fitted}"
    )


COMMANDS: dict[str, Callable[..., Any]] = {
    "robot": robot,
    "design": design,
    "frf": frf,
    "fit": fit,
    "rigid": identify_rigid.rigid,
    "axis": identify_axis.axis,
    "kinematics": identify_kinematics.kinematics,
    "friction": identify_friction.friction,
}
"""Subcommands of `flexros identify`, by name."""

HELP = "Identify springs, dampers and other parameters of a robot by experiments."
