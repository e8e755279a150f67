"""Command that measures the gap between a model and a recorded robot."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexros.cli.commands.diagnose import GAP_FOUND
from flexros.cli.guide import word
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
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.effects import RobotWithEffects
    from flexros.gap.held_out.left_over import LeftOver
    from flexros.gap.measure_gap import MeasuredGap
    from flexros.record.record import Record
    from flexros.robot import Robot


def gap(
    bag: Annotated[Path, typer.Argument(help="Log: rosbag2 folder, .mcap or .db3 file.")],
    model: KnownModelOption,
    patch: Path = typer.Option(None, "--patch", help="Patch of that robot, to measure the gap that it leaves."),
    tolerance: ToleranceOption = "",
    torque: TorqueOption = "command",
    prescribed: PrescribedOption = "",
    namespace: NamespaceOption = "",
    time_limit: float = typer.Option(
        None, "--time-limit", help="Time after which the fits of tolerated numbers end where they are [s]."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print the numbers as JSON, as in diagnosis.json."),
) -> int:
    """Measure the gap between a model and a log; the exit code is 1 where the model, with the patch, leaves a gap."""
    from flexros.effects.patching.patched_robot import load_model
    from flexros.gap.checked_log import checked_log
    from flexros.gap.fit.torques.rough_gains import with_gains
    from flexros.gap.measure_gap import measure_gap
    from flexros.gap.settings import DiagnosisSettings
    from flexros.logs.reader import read_log

    tolerances, source = parse_tolerance(tolerance), torque_source(torque)
    settings = DiagnosisSettings(time_limit=checked_limit(time_limit))
    nominal = load_model(model)
    repaired = None if patch is None else _repaired(patch, model)
    with progress_shown() as show:
        show("reading", 0.0)
        log = read_log(bag, namespace=namespace or None)
        models = (nominal,) if repaired is None else (repaired, nominal)
        record = _checked(
            models, partial(checked_log, log, name=bag.name, torque=source, prescribed=names_in(prescribed))
        )
        record = with_gains(record, nominal)  # one floor with and without a patch, whichever model checked the log
        measured = measure_gap(
            record, nominal, repaired=repaired, tolerance=tolerances, settings=settings, progress=show
        )
    if as_json:
        print_json(measured.numbers.model_dump(mode="json", exclude_none=patch is None))
    else:
        _print(measured)
        if patch is not None:
            _print_other_figures(patch, bag.name, measured)
        for text in measured.warnings:
            say(f"warning: {text}")
    suggest(next_step(bag, model, patch, measured.left), unless=as_json)
    return GAP_FOUND if measured.significant else 0


def next_step(bag: Path, model: str, patch: Path | None, left: LeftOver) -> str:
    """Return what to do after a gap was measured.

    Args:
        bag: The log.
        model: The model.
        patch: The patch; None without one.
        left: What the model, the repaired one where there is a patch, leaves.
    """
    if patch is not None and not left.significant:
        return f"flexros export {word(patch)} {_to_own_model(patch)}    the repair in your own model"
    if left.significant or left.assumed is not None:
        why = "which effect causes it" if left.significant else "which effects the assumed tolerance of torques hides"
        return f"flexros diagnose {word(bag)} --model {word(model)} --out diagnosis    {why}"
    return f"flexros monitor {word(bag)} --model {word(model)} --calibrate thresholds.yaml    watch that it stays so"


def _to_own_model(patch: Path) -> str:
    """Return the options of an export into the file that the robot of a patch was imported from; URDF for none."""
    from flexros.effects.patching.patched_robot import load_patched

    source = Path(load_patched(patch).base.spec.defaults.source)
    to = {".urdf": "urdf", ".xml": "mjcf", ".mjcf": "mjcf"}.get(source.suffix)
    if to is None:
        return "--to urdf --out repaired.urdf"
    return f"--to {to} --base {word(source)} --out repaired{source.suffix}"


def _checked(models: Sequence[RobotWithEffects], check: Callable[[Robot], Record]) -> Record:
    """Check a log with the first of some models that does not refuse it.

    A load that the nominal model lacks looks like a wrong unit, and so does friction of a patch where another model of
    that robot, too rough to tell, raises no doubt.

    Args:
        models: The models.
        check: Reads the log for a robot, and raises `InputError` where it refuses it.
    """
    refused: InputError | None = None
    for model in models:
        try:
            return check(model.robot)
        except InputError as error:
            refused = refused or error
    assert refused is not None
    raise refused


def _repaired(patch: Path, model: str) -> RobotWithEffects:
    """Load the patch; it must be one of this robot, else before and after would refer to two robots."""
    from flexros.effects.patching.patched_robot import load_patched

    _refuse_missing(patch)
    nominal, patched = load_patched(model), load_patched(patch)
    below = len(nominal.placed)
    if patched.base.model_hash != nominal.base.model_hash or patched.placed[:below] != nominal.placed:
        other = "another " if patched.base.name == nominal.base.name else ""
        raise InputError(
            f"--patch {patch} is on top of {other}{patched.base.name}, not of --model {model}; give that model"
        )
    return patched.model


def _refuse_missing(patch: Path) -> None:
    """Refuse a patch that a diagnosis did not write, with its verdict."""
    from flexros.gap.report.comparison import read_diagnosis
    from flexros.gap.report.files import DIAGNOSIS

    diagnosis = patch.with_name(DIAGNOSIS)
    if patch.exists() or not diagnosis.is_file():
        return
    verdict = read_diagnosis(diagnosis).verdict
    why = "found no gap" if verdict == "no_gap" else f"ended with {verdict} and no effect to repair the model by"
    raise InputError(
        f"{patch} does not exist, as the diagnosis in {patch.parent} {why}; leave it out to measure the model as it is",
        "patch",
    )


def _print_other_figures(patch: Path, log: str, measured: MeasuredGap) -> None:
    """Say why the diagnosis that made a patch states other figures, where it held this log out."""
    from flexros.gap.report.comparison import read_diagnosis
    from flexros.gap.report.files import DIAGNOSIS
    from flexros.gap.report.terminal import other_figures_line

    try:
        diagnosis = read_diagnosis(patch.with_name(DIAGNOSIS))
    except (InputError, OSError):
        return  # the patch was written by hand, or by another version
    line = other_figures_line(diagnosis, log, measured.numbers)
    if line:
        say(line)


def _print(measured: MeasuredGap) -> None:
    from flexros.gap.report.terminal import gap_line, gap_verdict, hidden_line, left_line

    console.print(gap_verdict(measured.left, "the model" if measured.numbers.after is None else "the repaired model"))
    say(gap_line(measured.numbers))
    say(left_line(measured.left))
    if hidden := hidden_line(measured.left):
        say(hidden)
