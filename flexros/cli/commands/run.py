"""Commands that run scenarios."""

from __future__ import annotations

import datetime
import shlex
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.cli.commands.view import PageBeside, require_viewer, show_log
from flexros.cli.options import NetworkOption, warn_of_network
from flexros.cli.output import console, print_json, say, suggest
from flexros.cli.progress import progress_bar, working
from flexros.config.yaml_file import parse_yaml
from flexros.errors import InputError, unknown_name
from flexros.scenario import transports

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from flexros.scenario.scenario import Scenario
    from flexros.scenario.transports import RunResult

TRANSPORTS = ("ros", "direct")

FIGURES = {
    "ros_domain_id": ("ROS domain", ""),
    "resends": ("states resent", ""),
    "dropped_on_purpose": ("messages dropped on purpose", ""),
    "missing_in_log": ("samples missing in the log", ""),
    "unseen_samples": ("samples that the controller never saw", ""),
    "samples_per_second": ("speed of the loop", "samples/s"),
    "cycles": ("paced cycles", ""),
    "rate_hz": ("mean rate", "Hz"),
    "period_p50_us": ("period, median", "µs"),
    "period_p99_us": ("period, 99 %", "µs"),
    "period_max_us": ("period, longest", "µs"),
    "lateness_p99_us": ("start after due, 99 %", "µs"),
    "lateness_max_us": ("start after due, longest", "µs"),
    "late": ("cycles late by more than a tenth", ""),
    "late_percent": ("share of late cycles", "%"),
    "bare_late_percent": ("late cycles of a loop that only sleeps, right after", "%"),
    "missed_commands": ("samples without command", ""),
    "real_time_priority": ("real-time priority", ""),
}
"""Name in words and unit of each figure of a run, by its key in the JSON output."""


def scenarios(as_json: bool = typer.Option(False, "--json", help="Print JSON.")) -> None:
    """List the built-in scenarios."""
    from flexros.scenario.scenario import load_scenario, scenario_names

    loaded = [load_scenario(name) for name in scenario_names()]
    if as_json:
        print_json([{"name": s.name, "robot": s.robot, "description": s.description} for s in loaded])
        return
    table = Table("scenario", "robot", "description")
    for scenario in loaded:
        table.add_row(scenario.name, scenario.robot, scenario.description)
    console.print(table)


def run(
    scenario: str = typer.Argument(help="Built-in scenario, or path of a scenario YAML."),
    model: str = typer.Option("", "--model", help="Robot instead of the scenario's: name, YAML or patch.yaml."),
    effect: list[str] = typer.Option(
        [],
        "--effect",
        help="Effect in the plant, NAME@LOCATION:parameter=value,... (may be repeated); a size may be given in noise "
        "floors of the robot, level=12floors.",
    ),
    setting: list[str] = typer.Option(
        [], "--set", help="Change a key of the scenario, e.g. sample_time=0.001 or plant.values.body_3.mass=190."
    ),
    seed: int = typer.Option(None, "--seed", help="Seed of noise and random disturbances."),
    out: Path = typer.Option(None, "--out", help="Folder of the log; default: bags/SCENARIO_<time>."),
    transport: str = typer.Option("", "--transport", help="ros or direct; default: ros where it is installed."),
    layout: str = typer.Option("composed", "--layout", help="Of the nodes: composed or processes."),
    realtime: bool = typer.Option(False, "--realtime", help="Pace the loop by the wall clock."),
    network: NetworkOption = False,
    parameter: list[str] = typer.Option(
        [], "--parameter", help="Node parameter, e.g. plant.drop_fraction=0.01 (may be repeated)."
    ),
    view: bool = typer.Option(
        False, "--view", help="Show the arm in the browser: over topics while it runs, then its log."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> int:
    """Run a scenario and record it."""
    if view:
        require_viewer()
    chosen = changed_scenario(scenario, model, setting, effect, seed)
    transport = choose_transport(transport, quiet=as_json)
    page = PageBeside(chosen.robot) if view and transport == "ros" else None
    folder = out or default_folder(chosen.name, transport)
    if transport == "direct":
        if realtime or network or parameter or layout != "composed":
            raise InputError(
                "--realtime, --network, --layout and --parameter belong to the ROS nodes; give --transport ros"
            )
        result = run_direct(chosen, folder)
    else:
        nodes = node_parameters(parameter)
        warn_of_network(network)
        with _shown(realtime, chosen.duration):
            result = transports.run_ros(chosen, folder, layout, realtime, nodes, network=network, beside=page)
    if as_json:
        print_json(result.as_dict())
    else:
        print_result(chosen.name, result)
    for warning in result.warnings:
        typer.echo(f"flexros: {warning}", err=True)
    if result.exit_code:
        typer.echo(f"flexros: {result.message}", err=True)
    elif result.log_folder is not None:
        log = shlex.quote(str(result.log_folder))
        suggest(f"flexros analyze {log} --report report.html    path error, tracking, timing", unless=as_json)
    if view and not result.exit_code:
        show_log(folder, None if page is None else page.port)
    return result.exit_code


def _shown(realtime: bool, duration: float | None) -> AbstractContextManager[None]:
    """Show that a run over topics is under way; a paced one is announced and then left alone."""
    if not realtime:
        return working("running over topics")
    length = "" if duration is None else f", {duration:g} s"
    typer.echo(f"flexros: running by the wall clock{length}", err=True)
    return nullcontext()


def run_direct(scenario: Scenario, folder: Path) -> RunResult:
    """Run a scenario in this process with a progress bar, see `transports.run_direct`."""
    with progress_bar() as bar:
        task = bar.add_task("preparing the reference", total=None)
        return transports.run_direct(
            scenario,
            folder,
            lambda done, total: bar.update(task, description="simulating", completed=done, total=total),
        )


def changed_scenario(
    name: str,
    model: str = "",
    settings: list[str] | None = None,
    effects: list[str] | None = None,
    seed: int | None = None,
) -> Scenario:
    """Load a scenario and apply the options of the command line.

    Args:
        name: Built-in scenario or file.
        model: Robot instead of the scenario's, also of one among the settings; empty for none.
        settings: Changes as key=value.
        effects: Effects of the plant as NAME@LOCATION:parameter=value,..., after those of the scenario.
        seed: Seed instead of the scenario's, also of one among the settings.

    Returns:
        The scenario.

    Raises:
        InputError: Something is unknown or not allowed.
    """
    from flexros.scenario.scenario import load_scenario

    changes = dict(key_and_value(text, "--set") for text in settings or [])
    sources = "command line", "--effect"
    return load_scenario(name).with_choices(model or None, changes, effects or (), seed, sources=sources)


def key_and_value(text: str, option: str) -> tuple[str, Any]:
    """Split key=value, the value read as YAML.

    Args:
        text: Value of the option.
        option: Name of the option, for the error text.

    Returns:
        Key and value.

    Raises:
        InputError: No equals sign, or the value is not YAML.
    """
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise InputError(f"{option} is '{text}', but must be key=value, e.g. sample_time=0.001")
    return key, parse_yaml(value, f"{option} {key}")


def node_parameters(texts: list[str]) -> dict[str, dict[str, Any]]:
    """Parse node parameters NODE.NAME=VALUE and group them by node.

    Args:
        texts: Values of the option.

    Returns:
        Values by node and name.

    Raises:
        InputError: The form is wrong.
    """
    by_node: dict[str, dict[str, Any]] = {}
    for text in texts:
        key, value = key_and_value(text, "--parameter")
        node, dot, name = key.partition(".")
        if not dot:
            raise InputError(f"--parameter is '{text}', but must be NODE.NAME=VALUE, e.g. plant.drop_fraction=0.01")
        by_node.setdefault(node, {})[name] = value
    return by_node


def choose_transport(given: str, quiet: bool = False) -> str:
    """Return the given transport; by default "ros" where the nodes are installed, else "direct", which is printed.

    Args:
        given: Value of the option; empty where it was not given.
        quiet: Do not print the choice of the default.

    Returns:
        "ros" or "direct".

    Raises:
        InputError: There is no such transport.
    """
    if given and given not in TRANSPORTS:
        raise unknown_name("transport", given, TRANSPORTS, "--transport")
    if given:
        return given
    runner, why = transports.ros_runner()
    if runner is None and not quiet:
        say(f"Running in-process: {why}.")
    return "ros" if runner else "direct"


def default_folder(name: str, transport: str) -> Path:
    """Return a log folder that does not exist yet.

    Args:
        name: Name of the scenario.
        transport: Its transport.

    Returns:
        bags/NAME_TRANSPORT_<time>, made unique by a number where needed; a slash in the name makes no folder.
    """
    stem = f"{name.replace('/', '_')}_{transport}_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}"
    folder = Path("bags") / stem
    number = 2
    while folder.exists():
        folder = Path("bags") / f"{stem}_{number}"
        number += 1
    folder.parent.mkdir(exist_ok=True)
    return folder


def print_result(name: str, result: RunResult) -> None:
    """Print the outcome of a run as a table.

    Args:
        name: Name of the scenario.
        result: The result.
    """
    table = Table(title=f"{name} over {result.transport}", show_header=False)
    table.add_row("samples", f"{result.samples}")
    table.add_row("simulated time", f"{result.simulated_time:.4g} s")
    table.add_row("wall time", f"{result.wall_time:.4g} s")
    for key, value in result.figures.items():
        table.add_row(*_figure(key, value))
    console.print(table)
    if result.message and not result.exit_code:
        say(f"{result.message[0].upper()}{result.message[1:]}.")
    if result.log_folder is not None:
        say(f"Log: {result.log_folder}")


def _figure(key: str, value: float) -> tuple[str, str]:
    """Return the label of a figure of a run, and its value with unit."""
    name, unit = FIGURES.get(key, (key.replace("_", " "), ""))
    if isinstance(value, bool):
        return name, "yes" if value else "no"
    return name, f"{value:.6g} {unit}".rstrip()
