"""Command that diagnoses the gap between a recorded robot and its model."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexros.cli.interruption import interruptible
from flexros.cli.options import (
    KnownModelOption,
    NamespaceOption,
    PrescribedOption,
    ToleranceOption,
    TorqueOption,
    checked_limit,
    names_in,
    parse_tolerance,
    torque_source,
)
from flexros.cli.output import console, print_json, say, suggest
from flexros.cli.progress import progress_shown

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.settings import DiagnosisSettings
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.record.topic_reader import TorqueSource
    from flexros.robot import Robot

GAP_FOUND = 1
"""Exit code when a gap was found."""


def diagnose(
    bag: Annotated[Path, typer.Argument(help="Log to fit effects to: rosbag2 folder, .mcap or .db3 file.")],
    model: KnownModelOption,
    out: Annotated[Path, typer.Option("--out", help="Folder for diagnosis.json, patch.yaml and report.html.")],
    holdout: Path = typer.Option(None, "--holdout", help="Held-out log; default: the last third of BAG."),
    tolerance: ToleranceOption = "",
    torque: TorqueOption = "command",
    prescribed: PrescribedOption = "",
    namespace: NamespaceOption = "",
    joints: str = typer.Option(
        "",
        "--joints",
        help="Motors at which effects compete: there, in their springs and bodies, e.g. motor_2,motor_3.",
    ),
    effects: str = typer.Option(
        "",
        "--effects",
        help="Effects that compete, e.g. coulomb_friction,backlash; center_error competes only where it is named here.",
    ),
    time_limit: float = typer.Option(
        None,
        "--time-limit",
        help="Time in which an answer must be found [s]. The search ends after four fifths of it, the check on "
        "held-out data follows, and where steps are missing the result is partial.",
    ),
    as_json: bool = typer.Option(False, "--json", help="Print diagnosis.json."),
) -> int:
    """Diagnose the gap between robot and model: where it shows, which effects cause it, and how far they close it.

    Ctrl-C ends the search as --time-limit does: what is known is written as a partial result. A second Ctrl-C ends the
    command, and nothing is written.
    """
    from flexros.effects.patching.patched_robot import load_model
    from flexros.gap.diagnose import diagnose as diagnosed
    from flexros.gap.report.files import check_folder, write_diagnosis

    check_folder(out)
    tolerances, source = parse_tolerance(tolerance), torque_source(torque)
    settings = _settings(names_in(joints), names_in(effects), time_limit)
    known = load_model(model)
    logs = _checked_logs(bag, holdout, known.robot, namespace, source, names_in(prescribed))
    with progress_shown() as show:
        with interruptible("writing what is known; Ctrl-C again ends without a result") as interrupted:
            result = diagnosed(
                logs.fitted,
                known,
                holdout=logs.held_out,
                log=logs.last,
                tolerance=tolerances,
                settings=settings,
                progress=show,
                interrupted=interrupted,
            )
        show("writing", 1.0)
        files = write_diagnosis(result, model, out)
    if as_json:
        print_json(result.diagnosis.model_dump(mode="json", by_alias=True))
    else:
        _print(result, [out / name for name in files])
        suggest(_next(result, bag, model, out, tolerance))
    return 0 if result.diagnosis.verdict == "no_gap" else GAP_FOUND


@dataclass(frozen=True, eq=False)
class _CheckedLogs:
    """Logs of a diagnosis.

    Attributes:
        fitted: The log to fit effects to.
        held_out: The held-out log; None where it is the last third of the fitted one.
        last: What the closed loop needs of the last one, as it was read.
    """

    fitted: Record
    held_out: Record | None
    last: Log


def _checked_logs(
    bag: Path, holdout: Path | None, robot: Robot, namespace: str, torque: TorqueSource, prescribed: tuple[str, ...]
) -> _CheckedLogs:
    """Read and check the fitted log and the held-out one."""
    from flexros.gap.checked_log import checked_log
    from flexros.gap.held_out.closed_loop_gap import measured_alone
    from flexros.logs.reader import read_log

    records = []
    for path in (bag, holdout):
        if path is not None:
            log = read_log(path, namespace=namespace or None, leave_out=("tool_reference",))
            second = path is holdout
            records.append(
                checked_log(log, robot, name=path.name, torque=torque, prescribed=prescribed, held_out=second)
            )
            log = measured_alone(log)
    fitted, *others = records
    return _CheckedLogs(fitted, others[0] if others else None, log)


def _next(result: DiagnosisResult, bag: Path, model: str, out: Path, tolerance: str) -> str:
    """Return what to do after a diagnosis: the experiment that decides, or a check of the repair on another log."""
    experiment = result.diagnosis.next_experiment
    if experiment is not None and experiment.command:
        return f"{experiment.command}    separates what this log does not"
    if result.diagnosis.verdict == "no_gap":
        agrees = str(out / "patch.yaml") if result.patch else model
        return f"flexros monitor {shlex.quote(str(bag))} --model {shlex.quote(agrees)} --calibrate thresholds.yaml"
    if result.patch:
        names = ",".join(result.robot.joint_names[motor] for motor in result.record.prescribed)
        alike = f" --prescribed {names}" if names else ""
        counted = _tolerance(result, tolerance)
        alike += f" --tolerance {counted}" if counted else ""
        patch = shlex.quote(str(out / "patch.yaml"))
        return f"flexros gap ANOTHER_LOG --model {shlex.quote(model)} --patch {patch}{alike}"
    return f"open {out / 'report.html'}: where the gap shows, and what the log does not determine"


def _tolerance(result: DiagnosisResult, stated: str) -> str:
    """Return the tolerances that count the gap of another log alike: those stated, or that of torques found.

    Args:
        result: The diagnosis.
        stated: The tolerances as they were given.
    """
    from flexros.gap.candidates.tolerance import TORQUE
    from flexros.gap.settings import NoiseSettings

    found = result.settings.noise.signal_tolerance
    usual = found == NoiseSettings().signal_tolerance or result.record.premises.floor_is_noise
    return stated if stated or usual else f"{TORQUE}={found:g}"


def _settings(joints: tuple[str, ...], effects: tuple[str, ...], time_limit: float | None) -> DiagnosisSettings:
    """Make the settings of the diagnosis from the options."""
    from flexros.gap.settings import DiagnosisSettings, SearchSettings

    return DiagnosisSettings(
        time_limit=checked_limit(time_limit), search=SearchSettings(effects=effects, joints=joints)
    )


def _print(result: DiagnosisResult, files: list[Path]) -> None:
    """Print the answer as text."""
    from flexros.gap.report import terminal
    from flexros.gap.report.verdict import partial_sentence
    from flexros.gap.report.words import undetermined_words
    from flexros.robot.exchange.joint_names import joints_line

    diagnosis = result.diagnosis
    console.print(terminal.verdict_line(diagnosis))
    if diagnosis.partial is not None:
        console.print(partial_sentence(diagnosis))
    if joints := joints_line(result.robot):
        console.print(joints)
    if result.ranking and diagnosis.verdict != "no_gap":
        console.print()
        console.print(terminal.ranking_table(result))
        if diagnosis.verdict == "unknown_effect":
            console.print("(probabilities among the known effects only, none of which explains the gap)")
        for line in undetermined_words(diagnosis.causes):
            console.print(line)
    for heading, lines in (
        ("Budget of the gap, in shares of it:", terminal.budget_lines(diagnosis)),
        ("Numbers of the model that are off, or that it lacks:", terminal.number_lines(diagnosis)),
        ("Left unexplained, in shares of the gap:", terminal.rest_lines(diagnosis)),
        ("Where it shows:", terminal.where_lines(result)),
        (
            "",
            (terminal.gap_line(diagnosis.gap), *terminal.group_lines(diagnosis), *terminal.tolerance_lines(diagnosis)),
        ),
        ("", terminal.next_lines(diagnosis)),
        ("", tuple(f"warning: {text}" for text in diagnosis.warnings)),
        ("", tuple(f"written: {path}" for path in files)),
    ):
        if lines:
            console.print()
        if heading and lines:
            console.print(heading)
        for line in lines:
            say(f"  {line}" if heading else line)
