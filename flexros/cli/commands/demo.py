"""The demonstration: the circle test over topics, recorded and compared; a gap closed; a measured machine's budget."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.padding import Padding
from rich.table import Table

from flexros.cli.commands import demo_measured, demo_repair
from flexros.cli.commands.run import choose_transport
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError
from flexros.scenario import transports

if TYPE_CHECKING:
    from flexros.analysis import Analysis
    from flexros.analysis.comparison import Comparison
    from flexros.cli.commands.demo_measured import Budgeted
    from flexros.cli.commands.demo_repair import Repair
    from flexros.logs.time_series import Log
    from flexros.scenario.scenario import Scenario
    from flexros.scenario.transports import RunResult

LOADS = (190.0, 210.0)
"""Mass of the last body in the plant when the load is off by 10 kg [kg]; the model keeps 200 kg."""


@dataclass(frozen=True)
class Case:
    """One run of the demonstration.

    Attributes:
        scenario: Built-in scenario.
        method: Name of the method in the table.
        case: Name of the case in the table.
        label: Name of the log folder.
        settings: Changes to the scenario.
    """

    scenario: str
    method: str
    case: str
    label: str
    settings: dict[str, Any]


@dataclass(frozen=True)
class CaseResult:
    """The result of one case.

    Attributes:
        case: The case.
        run: The run over the transport.
        analysis: Its log, analysed.
        equal: Whether the samples equal those of the in-process run; None where it was that run.
    """

    case: Case
    run: RunResult
    analysis: Analysis
    equal: bool | None


def cases() -> tuple[Case, ...]:
    """List the runs of the circle test and of the smooth case."""
    from flexros.analysis import circle_test as names

    methods = {
        "circle_pd": names.PD,
        "circle_fj": names.FLEXIBLE_JOINT,
        "circle_dae": names.DAE,
        "circle_dae2": names.DAE_SECOND_ORDER,
    }
    runs: list[Case] = []
    for scenario, method in methods.items():
        runs.append(Case(scenario, method, names.NOMINAL, scenario, {}))
        for mass in LOADS:
            label = f"{scenario}_load_{mass:.0f}kg"
            runs.append(Case(scenario, method, names.LOAD, label, {"plant.values.body_3.mass": mass}))
        runs.append(Case(scenario, method, names.SLOW, f"{scenario}_1ms", {"sample_time": 0.001}))
    runs += [
        Case("smooth_dae", names.DAE, names.SMOOTH, "smooth_dae", {}),
        Case("smooth_dae2", names.DAE_SECOND_ORDER, names.SMOOTH, "smooth_dae2", {}),
    ]
    return tuple(runs)


def demo(
    out: Path = typer.Option(None, "--out", help="Folder for logs and report; default: bags/demo_<time>."),
    transport: str = typer.Option("", "--transport", help="ros or direct; default: ros where it is installed."),
    with_repair: bool = typer.Option(
        True, "--repair/--no-repair", help="End with a hidden effect: diagnose it, repair the feedforward, run again."
    ),
    with_measured: bool = typer.Option(
        True, "--measured/--no-measured", help="End with the gap budget of a measured double pendulum."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> int:
    """Run the circle test of Moberg (2007, Paper B), then diagnose a hidden effect and a measured machine."""
    from flexros.analysis.report import write_comparison, write_report

    transport = choose_transport(transport, quiet=as_json)
    folder = out or Path("bags") / f"demo_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}"
    if folder.exists():
        raise InputError(f"the folder {folder} exists already; give another one with --out")
    folder.mkdir(parents=True)
    results = []
    with progress_bar() as progress:
        task = progress.add_task("circle test", total=len(cases()))
        for case in cases():
            progress.update(task, description=case.label)
            results.append(run_case(case, folder, transport))
            progress.advance(task)
    comparison = compare(results)
    write_comparison(comparison, folder / "report.html", title="Circle test of Paper B on the E12 robot")
    shown = next(result for result in results if result.case.label == "circle_dae2")
    write_report([shown.analysis], folder / "circle_dae2.html")
    if not as_json:
        _print(results, comparison, folder, transport)
    found = _repaired(folder, transport) if with_repair else None
    if found is not None and not as_json:
        demo_repair.print_repair(found, folder)
    measured = _measured(folder) if with_measured else None
    if measured is not None and not as_json:
        demo_measured.print_budget(measured)
    if as_json:
        parts = {"repair": found, "measured": measured}
        more = {name: part.as_dict() for name, part in parts.items() if part is not None}
        runs = [_row(result) for result in results]
        print_json({**comparison.as_dict(), "runs": runs, "folder": str(folder), **more})
    return 0


def _repaired(folder: Path, transport: str) -> Repair:
    """Diagnose and repair a hidden effect, and write the report of its runs."""
    from flexros.analysis.report import write_report

    with progress_bar() as progress:
        task = progress.add_task(demo_repair.HIDDEN, total=1.0)
        found = demo_repair.repair(
            folder, transport, lambda what, share: progress.update(task, description=what, completed=share)
        )
    write_report(found.runs, folder / demo_repair.REPORT)
    return found


def _measured(folder: Path) -> Budgeted:
    """Diagnose the measured machine."""
    with progress_bar() as progress:
        task = progress.add_task("measured machine", total=1.0)
        return demo_measured.budgeted(
            folder, lambda what, share: progress.update(task, description=what, completed=share)
        )


def run_case(case: Case, folder: Path, transport: str) -> CaseResult:
    """Run one case, read its log back and compare it with the in-process run.

    Args:
        case: The case.
        folder: Folder for the log.
        transport: "ros" or "direct".

    Raises:
        RunError: The run aborted.
    """
    from flexros.analysis import analyse
    from flexros.logs.reader import read_log
    from flexros.robot import load_robot
    from flexros.scenario.scenario import load_scenario

    scenario = load_scenario(case.scenario).with_values(case.settings, f"demo, {case.label}")
    bag = folder / case.label
    run = transports.run_direct(scenario, bag) if transport == "direct" else transports.run_ros(scenario, bag)
    run.require_complete(case.label)
    log = read_log(bag)
    equal = None if transport == "direct" else equal_to_direct(scenario, log)
    return CaseResult(case, run, analyse(log, robot=load_robot(scenario.robot), label=case.label), equal)


def equal_to_direct(scenario: Scenario, log: Log) -> bool:
    """Return whether stamps, encoder positions and commands equal those of the in-process run, bit for bit."""
    from flexros.scenario.closed_loop import closed_loop
    from flexros.scenario.experiment import Experiment

    direct = closed_loop(Experiment.prepare(scenario))
    if log.joint_commands is None or direct.joint_commands is None:
        return False
    pairs = (
        (log.joint_states.stamp, direct.joint_states.stamp),
        (log.joint_states.position, direct.joint_states.position),
        (log.joint_commands.stamp, direct.joint_commands.stamp),
        (log.joint_commands.effort, direct.joint_commands.effort),
    )
    return all(ours is not None and theirs is not None and np.array_equal(ours, theirs) for ours, theirs in pairs)


def compare(results: list[CaseResult]) -> Comparison:
    """Compare the runs with the published figures."""
    from flexros.analysis.circle_test import CAVEATS, QUOTED_FIGURES
    from flexros.analysis.comparison import Comparison, MethodRun

    runs = tuple(MethodRun(result.case.method, result.case.case, result.analysis) for result in results)
    return Comparison(runs, QUOTED_FIGURES, CAVEATS)


def _row(result: CaseResult) -> dict[str, Any]:
    return {"label": result.case.label, "equal_to_direct": result.equal, **result.run.as_dict()}


def _print(results: list[CaseResult], comparison: Comparison, folder: Path, transport: str) -> None:
    from flexros.analysis.terminal_tables import comparison_table

    console.print(comparison_table(comparison))
    for caveat in comparison.caveats:
        console.print(Padding(caveat, (0, 0, 0, 2)))
    if transport == "ros":
        table = Table("run over topics", "samples", "samples/s", "resends", "equal to in-process", title="Transport")
        for result in results:
            run = result.run
            speed = f"{run.figures.get('samples_per_second', 0):,.0f}"
            resends = f"{run.figures.get('resends', 0):.0f}"
            table.add_row(result.case.label, str(run.samples), speed, resends, "yes" if result.equal else "NO")
        console.print(table)
    say(f"Logs and report: {folder}; open {folder / 'report.html'} and {folder / 'circle_dae2.html'}")
