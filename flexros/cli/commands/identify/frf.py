"""Command that estimates frequency responses from a log of an identification experiment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.table import Table

from flexros.cli.commands.run import key_and_value
from flexros.cli.model import linear_robot
from flexros.cli.options import NamespaceOption
from flexros.cli.output import console, print_json, say, suggest
from flexros.cli.progress import progress_bar

if TYPE_CHECKING:
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.logs.time_series import Log
    from flexros.robot import Robot


def frf(
    log: Path = typer.Argument(help="Log folder (rosbag2), .mcap or .db3 file of an identification experiment."),
    out: Path = typer.Option(
        ..., "--out", help="File of the responses to write (netCDF); one that exists is replaced."
    ),
    scenario: str = typer.Option("", "--scenario", help="Scenario of the experiment; default: from the provenance."),
    setting: list[str] = typer.Option([], "--set", help="Choice of the estimation, e.g. average=arithmetic."),
    namespace: NamespaceOption = "",
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Estimate the frequency responses in all positions of an experiment."""
    from flexros.identify.frf.files.netcdf import save_responses
    from flexros.logs.reader import read_log
    from flexros.scenario.identification_plan import plan_of_log, plan_of_scenario
    from flexros.scenario.scenario import load_scenario

    recorded = read_log(log, namespace=namespace or None)
    if scenario:
        chosen = load_scenario(scenario)
        plan, reference = plan_of_scenario(chosen), chosen.robot
    else:
        plan, reference = plan_of_log(recorded), recorded.provenance["scenario"]["robot"]
    responses = _estimated(recorded, plan, linear_robot(reference), setting)
    save_responses(responses, out)
    if as_json:
        print_json([response_record(response) for response in responses])
        return
    print_responses(responses)
    say(f"Responses: {out}")
    suggest(f"flexros identify fit {out} --model {reference} --out identified    springs and dampers from them")


def _estimated(log: Log, plan: ExperimentPlan, robot: Robot, settings: list[str]) -> tuple[FrequencyResponse, ...]:
    """Estimate the responses of a log with a progress bar; `settings` are key=value of `FrfSettings`."""
    from flexros.config.settings import validate
    from flexros.identify.frf.positions import estimate_responses
    from flexros.identify.frf.settings import FrfSettings

    chosen = validate(FrfSettings, dict(key_and_value(text, "--set") for text in settings), "--set")
    with progress_bar() as bar:
        task = bar.add_task("frequency responses", total=len(plan.positions))
        return estimate_responses(
            log, plan, chosen, robot, progress=lambda done, whole: bar.update(task, completed=done, total=whole)
        )


def response_record(response: FrequencyResponse) -> dict[str, Any]:
    """Return the figures of a response for JSON; frequencies in Hz, deviations relative to the magnitude."""
    from flexros.analysis.frequency_responses import position_record

    kinds = (("total", response.total_error), ("noise", response.noise_error))
    deviations = {
        kind: float(np.median(response.standard_deviation(kind) / np.abs(response.response)))  # type: ignore[arg-type]
        for kind, error in kinds
        if error is not None
    }
    return {**position_record(response), "relative_std": deviations}


def print_responses(responses: tuple[FrequencyResponse, ...]) -> None:
    """Print responses for people."""
    records = [response_record(response) for response in responses]
    table = Table("no.", "gears", "blocks", "std [%]", "noise [%]")
    for number, record in enumerate(records, start=1):
        deviations = record["relative_std"]
        table.add_row(
            str(number),
            " ".join(f"{value:.2f}" for value in np.round(record["gears"], 2) + 0.0),
            str(record["blocks"]),
            *(f"{100 * deviations[kind]:.3g}" if kind in deviations else "-" for kind in ("total", "noise")),
        )
    console.print(table)
    bands = dict.fromkeys(
        f"{row['lines']} lines from {row['lowest_hz']:.3g} to {row['highest_hz']:.3g} Hz" for row in records
    )
    say(
        f"{len(records)} position{'s' * (len(records) > 1)}, {' or '.join(bands)}; std: standard deviation over "
        "magnitude, median of lines and elements; noise: estimated from the periods alone"
    )
    for warning in dict.fromkeys(text for response in responses for text in response.warnings):
        console.print(f"warning: {warning}")
