"""Command that identifies one axis with nonlinear gear and friction in the time domain."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.commands.identify.fit import value_bounds
from flexros.cli.commands.run import key_and_value
from flexros.cli.model import linear_robot
from flexros.cli.options import NamespaceOption, TorqueOption, torque_source
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working
from flexros.errors import InputError, unknown_name
from flexros.json_text import json_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.axis.resonances import Resonances
    from flexros.logs.time_series import Log
    from flexros.robot import Robot

RESULT = "axis.json"
"""Name of the file of the result."""


def axis(
    log: Path = typer.Argument(help="Log of the axis: folder (rosbag2), .mcap or .db3 file, moving from rest."),
    model: str = typer.Option(..., "--model", help="Nominal robot: built-in name or YAML."),
    out: Path = typer.Option(..., "--out", help="Folder for axis.json."),
    validation: Path = typer.Option(None, "--validation", help="Another log, on which the models are validated."),
    joint: str = typer.Option("motor_1", "--joint", help="Motor of the axis."),
    masses: int = typer.Option(2, "--masses", help="2: motor and arm, or 3: motor and two arm masses."),
    gear: str = typer.Option("piecewise", "--gear", help="Law of the gear: piecewise, cubic or linear."),
    stribeck: bool = typer.Option(False, "--stribeck", help="Friction falls with speed, by a Stribeck hump."),
    offset: bool = typer.Option(False, "--offset", help="A constant torque acts on the motor."),
    output: str = typer.Option("position", "--output", help="Measured signal to predict: position or velocity."),
    antiresonance: list[float] = typer.Option(
        [],
        "--antiresonance",
        help="Minimum of the response [Hz]; default: from an identification log, else --model.",
    ),
    resonance: list[float] = typer.Option([], "--resonance", help="Maximum of the response [Hz], equally many."),
    start: list[str] = typer.Option([], "--start", help="Initial value, e.g. gear_knee=0.002."),
    bound: list[str] = typer.Option([], "--bound", help="Bounds of a value, e.g. gear_knee=0.0005:0.01."),
    torque: TorqueOption = "command",
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Identify gear, friction and masses of one axis from its motion, with a nonlinear and with a linear gear."""
    from flexros.config.settings import validate
    from flexros.identify.axis import AxisStructure, identify_one_axis
    from flexros.identify.axis.result import result_record
    from flexros.identify.report.files import make_folder
    from flexros.logs.reader import read_log

    robot = linear_robot(model)
    if joint not in robot.joint_names:
        raise unknown_name("joint", joint, robot.joint_names, f"--joint, robot {robot.name}")
    rotary = robot.motors[robot.joint_names.index(joint)].rotary
    chosen = torque_source(torque)
    settings = {"masses": masses, "gear": gear, "stribeck": stribeck, "offset": offset, "output": output}
    structure = validate(AxisStructure, {**settings, "rotary": rotary}, "command line")
    starts, bounds = _values(start), value_bounds(bound, "gear_knee=0.0005:0.01")
    logs = {"log": read_log(log, namespace=namespace or None)}
    if validation:
        logs["validation"] = read_log(validation, namespace=namespace or None)
    frequencies = _given(antiresonance, resonance) or _resonances(logs["log"], robot, joint, masses - 1, bool(starts))
    with working("fitting prediction errors"):
        identification = identify_one_axis(
            logs["log"], robot, structure, joint=joint, antiresonances=frequencies.antiresonances,
            resonances=frequencies.resonances, start=starts, bounds=bounds, validation=logs.get("validation"),
            torque=chosen,
        )  # fmt: skip
    sources = {name: {"file": str(path), **logs[name].provenance} for name, path in _files(log, validation)}
    record = result_record(identification, joint, frequencies, sources)
    make_folder(out)
    write_result(out / RESULT, json_text(record), "result")
    if as_json:
        print_json(record)
        return
    _print(record)
    say(f"Result: {out / RESULT}")


def _files(log: Path, validation: Path | None) -> list[tuple[str, Path]]:
    return [("log", log), *([("validation", validation)] if validation else [])]


def _values(texts: list[str]) -> dict[str, float]:
    """Read NAME=VALUE; names are checked with the structure."""
    values = {}
    for text in texts:
        name, value = key_and_value(text, "--start")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"--start {name} is '{value}', but must be a number, e.g. gear_knee=0.002")
        values[name] = float(value)
    return values


def _given(antiresonances: list[float], resonances: list[float]) -> Resonances | None:
    from flexros.identify.axis.resonances import Resonances

    if not antiresonances and not resonances:
        return None
    return Resonances(tuple(antiresonances), tuple(resonances), "command line")


def _resonances(log: Log, robot: Robot, joint: str, count: int, started: bool) -> Resonances:
    """Return the frequencies of the response of an identification log, else those of the robot."""
    from flexros.analysis.frequency_responses import log_responses
    from flexros.identify.axis.resonances import Resonances, resonances_of_response, resonances_of_robot

    responses = log_responses(log)
    for response in () if responses is None else responses.positions:
        measured = resonances_of_response(response, joint, count)
        if measured is not None:
            return measured
    of_robot = resonances_of_robot(robot, joint, count)
    if of_robot is None and not started:
        raise InputError(
            f"robot {robot.name} has fewer antiresonances of {joint} than the {count} of a model of {count + 1} "
            "masses; give --antiresonance and --resonance, or another robot"
        )
    return of_robot or Resonances((), (), "nothing")


def _print(record: Mapping[str, Any]) -> None:
    """Print parameters, fit qualities and gain for people."""
    from flexros.identify.report.words import interval_text

    table = Table("parameter", "value", "95 % interval", "linear gear", "unit")
    table.columns[0].overflow = "fold"
    linear = {row["name"]: row["value"] for row in record["linear"]["parameters"]}
    for row in record["nonlinear"]["parameters"]:
        ends = row["interval"]
        linear_gear = f"{linear[row['name']]:.5g}" if row["name"] in linear else "-"
        interval = "unknown" if ends is None else interval_text(ends[0], row["value"], ends[1])
        table.add_row(row["name"], f"{row['value']:.5g}", interval, linear_gear, row["unit"])
    console.print(table)
    listed = [", ".join(f"{value:.4g}" for value in record[key]) for key in ("antiresonances_hz", "resonances_hz")]
    say(f"Started from antiresonances {listed[0]} Hz and resonances {listed[1]} Hz ({record['frequencies_from']})")
    for name in ("fit", "validation"):
        if record["nonlinear"][name] is not None:
            say(f"{name.capitalize()}: {_words(record, name)}")
    where = "the validation log" if record["gain_on"] == "validation" else "the log it was fitted to"
    if record["structure"]["gear"] != "linear" and record["gain"] is not None:
        say(f"The nonlinear gear removes {100 * record['gain']:.1f} % of the prediction error on {where}")
    for warning in record["warnings"]:
        say(f"warning: {warning}")


def _words(record: Mapping[str, Any], name: str) -> str:
    """Return the fit qualities of both models in one line."""
    parts = []
    for model, gear in (("nonlinear", record["structure"]["gear"]), ("linear", "linear")):
        quality = record[model][name]
        prediction, simulation = (
            "unknown" if (share := quality[f"{kind}_percent"]) is None else f"{share:.{places}f} %"
            for kind, places in (("prediction", 4), ("simulation", 2))
        )
        parts.append(f"{gear} gear: prediction {prediction}, simulation {simulation}")
    return "; ".join(dict.fromkeys(parts))
