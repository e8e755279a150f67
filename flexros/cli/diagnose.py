"""Command that diagnoses the gap between a recorded robot and its model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexros.cli.options import (
    KnownModelOption,
    NamespaceOption,
    ToleranceOption,
    TorqueOption,
    parse_tolerance,
    torque_source,
)
from flexros.cli.output import console, print_json, progress_bar, say

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.progress import Progress, TaskID

    from flexros.gap.result import DiagnosisResult

GAP_FOUND = 1
"""Exit code when a gap was found."""


def diagnose(
    bag: Annotated[Path, typer.Argument(help="Log to fit effects to: rosbag2 folder or .mcap file.")],
    model: KnownModelOption,
    out: Annotated[Path, typer.Option("--out", help="Folder for diagnosis.json, patch.yaml and report.html.")],
    holdout: Path = typer.Option(None, "--holdout", help="Held-out log; default: the last third of BAG."),
    tolerance: ToleranceOption = "",
    torque: TorqueOption = "command",
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print diagnosis.json."),
) -> int:
    """Diagnose the gap between robot and model: where it shows, which effects cause it, and how far they close it."""
    from flexros.effects.patching.patched_robot import load_model
    from flexros.gap.checked_log import checked_log
    from flexros.gap.diagnose import diagnose as diagnosed
    from flexros.gap.report.files import check_folder, write_diagnosis
    from flexros.logs.reader import read_log

    check_folder(out)
    tolerances, source = parse_tolerance(tolerance), torque_source(torque)
    known = load_model(model)
    logs = [read_log(path, namespace=namespace or None) for path in (bag, holdout) if path is not None]
    paths = [path for path in (bag, holdout) if path is not None]
    records = [checked_log(log, known.robot, name=path.name, torque=source) for log, path in zip(logs, paths)]
    record, *others = records
    with progress_bar() as bar:
        task = bar.add_task("reading", total=1.0)
        result = diagnosed(
            record,
            known,
            holdout=others[0] if others else None,
            log=logs[-1],
            tolerance=tolerances,
            progress=_progress_on(bar, task),
        )
        bar.update(task, description="writing")
        files = write_diagnosis(result, model, out)
    if as_json:
        print_json(result.diagnosis.model_dump(mode="json", by_alias=True))
    else:
        _print(result, [out / name for name in files])
    return 0 if result.diagnosis.verdict == "no_gap" else GAP_FOUND


def _progress_on(bar: Progress, task: TaskID) -> Callable[[str, float], None]:
    """Show stage and share; a stage starts its remaining time anew where the number of its steps was unknown."""

    def show(stage: str, share: float) -> None:
        if share < bar.tasks[0].completed:
            bar.reset(task)
        bar.update(task, description=stage, completed=share)

    return show


def _print(result: DiagnosisResult, files: list[Path]) -> None:
    """Print the answer as text."""
    from flexros.gap.report import terminal

    diagnosis = result.diagnosis
    console.print(terminal.verdict_line(diagnosis))
    if result.ranking and diagnosis.verdict != "no_gap":
        console.print()
        console.print(terminal.ranking_table(result))
        if diagnosis.verdict == "unknown_effect":
            console.print("(probabilities among the known effects only, none of which explains the gap)")
    for heading, lines in (
        ("Budget of the gap:", terminal.budget_lines(diagnosis)),
        ("Where it shows:", terminal.where_lines(result)),
        ("", (terminal.gap_line(diagnosis.gap), *terminal.group_lines(diagnosis), *terminal.next_lines(diagnosis))),
        ("", tuple(f"warning: {text}" for text in diagnosis.warnings)),
        ("", tuple(f"written: {path}" for path in files)),
    ):
        if lines:
            console.print()
        if heading and lines:
            console.print(heading)
        for line in lines:
            say(f"  {line}" if heading else line)
