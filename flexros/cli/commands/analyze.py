"""Command that analyses a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexros.cli.model import robot_of_run
from flexros.cli.options import NamespaceOption
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import FlexrosError

if TYPE_CHECKING:
    from flexros.analysis.run_analysis import Analysis
    from flexros.logs.time_series import Log
    from flexros.report.page import Chapter


def analyze(
    bag: list[Path] = typer.Argument(help="Log folder (rosbag2), .mcap or .db3 file; several are shown side by side."),
    model: str = typer.Option("", "--model", help="Robot of the run, for its limits; default: from the provenance."),
    namespace: NamespaceOption = "",
    report: Path = typer.Option(None, "--report", help="Write an HTML report that opens offline."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Report path error, tracking, loop timing, and frequency responses of periodic runs."""
    from flexros.analysis import analyse
    from flexros.analysis.report import write_report
    from flexros.analysis.terminal_tables import terminal_table
    from flexros.logs.reader import read_log

    analyses = []
    with progress_bar() as bar:
        task = bar.add_task("reading", total=2 * len(bag) + bool(report))
        for path, label in zip(bag, _labels(bag), strict=True):
            log = read_log(path, namespace=namespace or None)
            bar.update(task, advance=1, description=f"analysing {path.name}")
            analyses.append(analyse(log, robot=robot_of_run(model, log), label=label))
            bar.update(task, advance=1, description="reading")
        if report:
            bar.update(task, description="writing the report")
            write_report(analyses, report, further=_motion(log, bag[0], model, analyses[0]) if len(bag) == 1 else ())
    if as_json:
        dicts = [analysis.as_dict() for analysis in analyses]
        print_json(dicts[0] if len(dicts) == 1 else dicts)
        return
    console.print(terminal_table(analyses))
    for analysis in analyses:
        for warning in analysis.warnings:
            console.print(f"warning, {analysis.label}: {warning}")
    if report:
        say(f"report: {report}")


def _motion(log: Log, bag: Path, model: str, analysis: Analysis) -> tuple[Chapter, ...]:
    """Return the chapter of the moving arm; none where the robot of the log is not known."""
    from flexros.effects.patching.patched_robot import load_model
    from flexros.view.animation import motion_chapter
    from flexros.view.shown import robot_of

    path = analysis.path
    commanded = path.run.commanded if path is not None and len(path.axes) > 1 else None
    try:
        return (motion_chapter(log, load_model(model or robot_of(log, bag)), bag.name, commanded),)
    except FlexrosError:
        return ()


def _labels(bag: list[Path]) -> list[str | None]:
    """Label runs by their folders, or by their paths where folders have the same name."""
    if len(bag) == 1:
        return [None]
    names = [path.absolute().name for path in bag]
    return [str(path) if names.count(name) > 1 else name for path, name in zip(bag, names, strict=True)]
