"""Command that identifies the rigid model of a robot from logs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flexros.atomic_file import write_result
from flexros.cli.commands.identify.table import fitting_table
from flexros.cli.model import linear_robot
from flexros.cli.options import NamespaceOption, PrescribedOption, TorqueOption, names_in, torque_source
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError
from flexros.json_text import json_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_MOST_LINES = 3
"""Most lines of one kind that are printed (chosen); the result file has all."""


def rigid(
    log: list[Path] = typer.Argument(help="Log to identify from, then logs to test the model on."),
    model: str = typer.Option(
        ..., "--model", help="Robot: built-in name or YAML; all its springs are treated as rigid."
    ),
    out: Path = typer.Option(..., "--out", help="Folder for rigid.json and identified.yaml."),
    asymmetric: bool = typer.Option(
        False, "--asymmetric", help="Friction depends on the direction of motion, no offset."
    ),
    cutoff: float = typer.Option(
        None, "--cutoff", help="Low-pass of the positions [Hz]; default: a tenth of the rate, at most 100."
    ),
    hold: bool = typer.Option(
        False, "--hold", help="Pair positions with the command as it acts (delayed, held), not with its samples."
    ),
    torque: TorqueOption = "command",
    prescribed: PrescribedOption = "",
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Identify masses, inertias and friction of the rigid robot by linear regression."""
    from flexros.identify.rigid.fit import cross_test, fit_rigid
    from flexros.identify.rigid.identified_robot import identified_yaml
    from flexros.identify.rigid.result import result_record
    from flexros.identify.rigid.settings import RigidSettings
    from flexros.identify.rigid.verdict import judge_fit
    from flexros.logs.reader import read_log

    if cutoff is not None and cutoff <= 0:
        raise InputError(f"--cutoff is {cutoff:g} Hz, but must be positive")
    robot = linear_robot(model)
    logs = {label: read_log(path, namespace=namespace or None) for label, path in _labelled(log).items()}
    fitted, *tested = logs
    settings = RigidSettings(
        cutoff=cutoff, asymmetric=asymmetric, hold=hold, torque=torque_source(torque), prescribed=names_in(prescribed)
    )
    with progress_bar() as progress:
        task = progress.add_task("regression", total=len(logs))

        def at(step: int) -> Callable[[float], None]:
            return lambda share: progress.update(task, completed=step + share)

        fit = fit_rigid(logs[fitted], robot, settings, fitted, at(0))
        tests = [cross_test(fit, logs[label], label, at(step)) for step, label in enumerate(tested, start=1)]
    verdict = judge_fit(fit)
    record = result_record(fit, verdict, tests, {label: dict(entry.provenance) for label, entry in logs.items()})
    written = _write(record, identified_yaml(fit, verdict.identified) if verdict.usable else None, out)
    if as_json:
        print_json(record)
    else:
        _print(record)
        say(written)
    if not verdict.usable:
        raise InputError(f"no robot file was written: {verdict.sentence}")


def _write(record: Mapping[str, Any], robot: str | None, out: Path) -> str:
    """Write the result, and the text of the identified robot unless there is none; return where they are."""
    out.mkdir(parents=True, exist_ok=True)
    result, robot_file = out / "rigid.json", out / "identified.yaml"
    write_result(result, json_text(record), "result")
    if robot is None:
        robot_file.unlink(missing_ok=True)  # a file of an earlier run would pass for the result of this one
        return f"Result: {result}"
    write_result(robot_file, robot, "identified robot")
    return f"Result: {result}; identified robot: {robot_file}"


def _labelled(paths: list[Path]) -> dict[str, Path]:
    """Label logs by their folders, or by their paths where folders have the same name."""
    names = [path.absolute().name for path in paths]
    return {str(path) if names.count(name) > 1 else name: path for name, path in zip(names, paths, strict=True)}


def _print(record: Mapping[str, Any]) -> None:
    """Print verdict, parameters and errors for people."""
    say(f"Verdict: {record['verdict']['sentence']}")
    rows = record["parameters"]
    columns = {
        "base parameter": [row["name"] for row in rows],
        "unit": [row["unit"] for row in rows],
        "nominal": [f"{row['nominal']:.6g}" for row in rows],
        "value": [f"{row['value']:.6g}" for row in rows],
        "± std": ["kept" if row["std"] is None else f"{row['std']:.3g}" for row in rows],
    }
    console.print(fitting_table(columns, console.width, ("nominal",)))
    for row in record["parameters"]:
        if len(row["combination"]) > 1:
            say(f"{row['name']} = {row['words']}")
    errors = record["force_error_percent"]
    say(f"Force error: {errors['fit']['total']:.4f} % in {errors['fit']['log']}")
    for test in errors["cross_tests"]:
        say(f"Force error: {test['total']:.4f} % in {test['log']} (cross-test)")
    if errors["fit_with_hold"] is not None and errors["fit_with_hold"] < errors["fit"]["total"]:
        say(f"With delay and hold of the command (--hold): {errors['fit_with_hold']:.4f} %")
    _print_excitation(record["excitation"], len(rows))
    if record["verdict"]["usable"]:
        _print_robot_file(record)
    for warning in record["warnings"]:
        say(f"warning: {warning}")


def _print_excitation(verdict: Mapping[str, Any], n_parameters: int) -> None:
    """Print whether the motion excites all parameters, and if not, why."""
    missing, number, limit = verdict["not_excited"], verdict["condition_number"], verdict["largest_condition_number"]
    condition = f"condition number {number:.4g} (up to {limit:g})"
    if verdict["rich_enough"]:
        say(f"Excitation rich enough: {condition}, all {n_parameters} base parameters excited")
    else:
        reasons = [f"{len(missing)} of {n_parameters} base parameters are not excited"] if missing else []
        if number > limit:
            reasons.append(f"condition number {number:.4g} is above {limit:g}")
        rest = f"; the others are well conditioned, {condition}" if number <= limit else ""
        say(f"Excitation NOT rich enough: {' and '.join(reasons)}{rest}")
    for entry in missing:
        say(f"not excited: {entry['name']}, {entry['reason']}; its nominal value is kept")


def _print_robot_file(record: Mapping[str, Any]) -> None:
    """Print what the robot file does not hold."""
    outside = record["not_in_robot_file"]
    if outside["values"]:
        units = {row["name"]: row["unit"] for row in record["parameters"]}
        named = ", ".join(f"{name} {value:.4g} {units[name]}" for name, value in outside["values"].items())
        effects = " ".join(f"--effect {effect}" for effect in outside["effects"])
        say(f"not in the robot file: {named}" + (f"; add to a run: {effects}" if effects else ""))
    for sentence in record["means_in_robot_file"]:
        say(sentence)
    _say_some(
        [
            f"left at nominal in the robot file: {owner} ({reason})"
            for owner, reason in record["left_at_nominal"].items()
        ]
    )
    _say_some(
        [
            f"not met by the robot file: {name}, which is {value:.6g} there, since no feasible robot has it"
            for name, value in record["not_met"].items()
        ]
    )


def _say_some(lines: list[str]) -> None:
    """Print a few lines, and the number of all."""
    for line in lines[:_MOST_LINES]:
        say(line)
    if len(lines) > _MOST_LINES:
        say(f"... {len(lines)} such lines in all, see rigid.json")
