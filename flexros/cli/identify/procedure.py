"""Commands that identify a robot: the whole procedure, and its steps singly."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flexros.cli import transports
from flexros.cli.identify import axis as identify_axis
from flexros.cli.identify import rigid as identify_rigid
from flexros.cli.identify.design import (
    POSITIONS,
    RANGE,
    UNKNOWN,
    checked_minutes,
    chosen_names,
    design,
    designed,
    gear_ranges,
    template_with,
)
from flexros.cli.identify.fit import BOUND, fit, print_identification, search_settings, searched
from flexros.cli.identify.frf import estimated, frf
from flexros.cli.model import linear_robot
from flexros.cli.output import print_json, say
from flexros.cli.run import choose_transport
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.cli.transports import RunResult
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.identify.result import IdentificationResult
    from flexros.identify.search import SearchSettings
    from flexros.robot import Robot
    from flexros.scenario.scenario import Scenario

LAYOUTS = ("composed", "processes")
"""Layouts of the nodes."""

OUT = "Folder for scenario, log, responses, identified robot and report; one that holds a log already is refused."
REAL = (
    "Robot YAML that plays the real one; default: ROBOT itself. It may differ in numbers of the equations of motion; "
    "other structures, sensors and limits are refused."
)
"""Helps of options."""


def robot(
    name: str = typer.Argument(help="Robot as it is thought to be: shipped name or YAML.", metavar="ROBOT"),
    out: Path = typer.Option(
        ...,
        "--out",
        help=OUT,
    ),
    positions: int = typer.Option(0, "--positions", help="Number of positions; default: 15, or as many as unknowns."),
    candidates: int = typer.Option(4000, "--candidates", help="Number of positions to choose from."),
    ranges: list[str] = typer.Option([], "--range", help=RANGE),
    minutes: float = typer.Option(30.0, "--minutes", help="Robot time up to which transient periods are added."),
    scenario: str = typer.Option("", "--scenario", help="Excitation and controller; default: chosen for the robot."),
    real: str = typer.Option(
        "",
        "--real",
        help=REAL,
    ),
    effect: list[str] = typer.Option(
        [], "--effect", help="Effect in the plant, NAME@LOCATION:parameter=value,... (may be repeated)."
    ),
    setting: list[str] = typer.Option(
        [], "--set", help="Key of the scenario, e.g. plant.values.body_3.mass=290 or identification.blocks=3."
    ),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    estimator: str = typer.Option("LLS", "--estimator", help="LLS, LLSM (magnitude only) or NLS."),
    weights: str = typer.Option("combined", "--weights", help="Of the last fit: user, optimal or combined."),
    starts: int = typer.Option(20, "--starts", help="Number of starts, the first one at the nominal values."),
    bound: list[str] = typer.Option([], "--bound", help=BOUND),
    transport: str = typer.Option("", "--transport", help="ros or direct; default: ros where it is installed."),
    layout: str = typer.Option("composed", "--layout", help="Of the nodes: composed or processes."),
    seed: int = typer.Option(1, "--seed", help="Seed of candidates, excitation, noise and starts."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> int:
    """Design an experiment, run it, estimate frequency responses, fit the parameters, and report."""
    from flexros.identify.design.experiment_design import DesignSettings
    from flexros.identify.report.files import make_folder

    log = out / "log"
    if log.exists():
        raise InputError(_log_exists(log, name))
    checked_minutes(minutes)
    if layout not in LAYOUTS:
        raise unknown_name("layout", layout, LAYOUTS, "--layout")
    nominal = linear_robot(name)
    names = chosen_names(nominal, unknown)
    search = search_settings(nominal, names, estimator, weights, starts, seed, bound)
    template = with_real_robot(
        template_with(name, nominal, scenario, [*setting, f"seed={seed}"], effect), nominal, real
    )
    transport = choose_transport(transport, quiet=as_json)
    make_folder(out)
    wanted = DesignSettings(positions or min(POSITIONS, len(names)), candidates, seed=seed)
    _stage("designing the experiment")
    found, experiment, factor = designed(
        nominal, names, template, wanted, gear_ranges(nominal, ranges), out / "experiment.yaml", minutes
    )
    _tell_robot_time(experiment, quiet=as_json)
    _stage("running the experiment")
    run = _run(experiment, log, transport, layout)
    if run.exit_code:
        typer.echo(f"flexros: {run.message}", err=True)
        return run.exit_code
    result = _identified(nominal, names, experiment, run, found, factor, search, out)
    if as_json:
        print_json({**result.as_dict(), "run": run.as_dict()})
    else:
        print_identification(result, out)
        if result.facts is not None:
            say(f"Robot time: {result.facts.robot_time / 60:.3g} min")
    return 0


def _stage(what: str) -> None:
    """Say what begins, where no progress bar shows it."""
    if not sys.stderr.isatty():
        typer.echo(f"flexros: {what}", err=True)


def _tell_robot_time(experiment: Scenario, quiet: bool) -> None:
    """Say how long the robot will be at work."""
    from flexros.scenario.identification_plan import plan_of_scenario

    if not quiet and experiment.identification is not None:
        minutes = plan_of_scenario(experiment).duration / 60
        positions = len(experiment.identification.positions)
        say(f"Experiment in {positions} position{'s' * (positions != 1)}: {minutes:.3g} min of robot time")


def with_real_robot(template: Scenario, nominal: Robot, real: str) -> Scenario:
    """Let a robot file play the real robot.

    Args:
        template: The experiment.
        nominal: The robot as it is thought to be.
        real: Name or file of the robot that plays the real one; empty for none.

    Returns:
        The experiment with the values of the plant; those that were set one by one count more.

    Raises:
        InputError: The robots differ in more than numbers.
    """
    from flexros.identify.design.stand_in import stand_in_values

    if not real:
        return template
    values = {**stand_in_values(nominal, linear_robot(real)), **template.plant.values}
    return template.with_values({"plant": {**template.plant.model_dump(mode="json"), "values": values}}, "--real")


def _log_exists(log: Path, name: str) -> str:
    """Say what can be done where an experiment was made already."""
    responses, fitted = log.parent / "frf.nc", log.parent / "fit"
    return (
        f"the log folder {log} exists already; give another folder with --out, or go on with this log: flexros "
        f"identify frf {log} --out {responses}; flexros identify fit {responses} --model {name} --out {fitted}"
    )


def _run(experiment: Scenario, log: Path, transport: str, layout: str) -> RunResult:
    if transport == "direct":
        return transports.run_direct(experiment, log)
    return transports.run_ros(experiment, log, layout)


def _identified(
    nominal: Robot,
    names: tuple[str, ...],
    experiment: Scenario,
    run: RunResult,
    found: ExperimentDesign,
    factor: float,
    settings: SearchSettings,
    out: Path,
) -> IdentificationResult:
    """Estimate, fit, judge and write everything into the folder."""
    from flexros.identify.report.files import write_identification
    from flexros.identify.result import ExperimentFacts, identification_result
    from flexros.logs.reader import read_log
    from flexros.scenario.experiment import Experiment
    from flexros.scenario.identification_plan import plan_of_log

    log = read_log(out / "log")
    plan = plan_of_log(log)
    _stage("estimating frequency responses")
    responses = estimated(log, plan, nominal, out / "frf.nc")
    _stage(f"fitting from {settings.starts} start{'s' * (settings.starts != 1)}")
    fitted = searched(nominal, responses, names, settings)
    plant = Experiment.prepare(experiment).plant
    lowered = f"Amplitudes were lowered to {100 * factor:.3g} % of the template's because of the torque limits."
    result = identification_result(
        fitted.problem,
        fitted.fit,
        fitted.searched,
        design=found,
        facts=ExperimentFacts.of(plan, "log", run.transport),
        truth=_truth(plant, nominal, names),
        warnings=((lowered,) if factor < 1 else ()) + fitted.warnings,
        provenance=log.provenance,
    )
    write_identification(result, out, f"experiment {experiment.name}")
    return result


def _truth(plant: Robot, nominal: Robot, names: tuple[str, ...]) -> dict[str, float]:
    """List the values of the simulated robot, without those that mean something else there (factors on other laws)."""
    known = plant.parameters
    return {name: known[name].value for name in names if known[name].unit == nominal.parameters[name].unit}


COMMANDS: dict[str, Callable[..., Any]] = {
    "robot": robot,
    "design": design,
    "frf": frf,
    "fit": fit,
    "rigid": identify_rigid.rigid,
    "axis": identify_axis.axis,
}
"""Subcommands of `flexros identify`, by name."""

HELP = "Identify springs, dampers and other parameters of a robot by experiments."
