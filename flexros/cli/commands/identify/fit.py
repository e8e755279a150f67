"""Command that fits parameters to frequency responses, and how an identification is printed."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexros.cli.commands.identify.design import UNKNOWN
from flexros.cli.commands.identify.table import parameter_table
from flexros.cli.model import linear_robot
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult

BOUND = "Of a value [SI], NAME=LOW:HIGH (may be repeated); default: a factor of 10 either way."
"""Help of the option that bounds values."""


def fit(
    responses: Path = typer.Argument(help="File of frequency responses (netCDF), from: flexros identify frf."),
    model: str = typer.Option(..., "--model", help="Nominal robot: built-in name or YAML."),
    out: Path = typer.Option(
        ...,
        "--out",
        help="Folder for identified.yaml, identification.json and report.html; those of an earlier fit are replaced.",
    ),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    estimator: str = typer.Option("LLS", "--estimator", help="LLS, LLSM (magnitude only) or NLS."),
    weights: str = typer.Option("combined", "--weights", help="Of the last fit: user, optimal or combined."),
    starts: int = typer.Option(20, "--starts", help="Number of initial values, the first are the nominal ones."),
    seed: int = typer.Option(1, "--seed", help="Seed of the initial values."),
    bound: list[str] = typer.Option([], "--bound", help=BOUND),
    scheduler: str = typer.Option("", "--scheduler", help="Address of a Dask scheduler whose workers fit."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Fit unknown parameters to measured frequency responses, from several initial values."""
    from flexros.identify.frf.files.netcdf import load_responses
    from flexros.identify.graybox.search import SearchSettings
    from flexros.identify.report.files import write_identification
    from flexros.identify.report.record import identification_record
    from flexros.identify.result import fit_responses
    from flexros.provenance import versions
    from flexros.scenario.identification import unknown_names
    from flexros.scheduler import connected

    robot = linear_robot(model)
    names = unknown_names(robot, unknown)
    settings = SearchSettings(estimator, weights, starts, seed, value_bounds(bound))
    settings.check(robot, names)
    measured = load_responses(responses)
    with ExitStack() as stack:
        client = stack.enter_context(connected(scheduler)) if scheduler else None
        bar = stack.enter_context(progress_bar())
        task = bar.add_task("fits", total=settings.starts)
        result = fit_responses(
            robot,
            measured,
            names,
            settings,
            provenance={"responses": responses.name, "robot": robot.name, "seed": seed, "versions": versions()},
            client=client,
            progress=lambda done: bar.update(task, completed=done),
        )
    write_identification(result, out, responses.name)
    if as_json:
        print_json(identification_record(result))
    else:
        print_identification(result, out)


def value_bounds(texts: list[str], example: str = "body_1.ry.stiffness=1e4:1e6") -> dict[str, tuple[float, float]]:
    """Parse bounds of values, NAME=LOW:HIGH.

    Args:
        texts: The values of the option.
        example: One that may be given, for the error message.

    Returns:
        Lower and upper bound [SI] by name.

    Raises:
        InputError: Not a name and two numbers.
    """
    bounds = {}
    for text in texts:
        name, _, pair = text.partition("=")
        low, _, high = pair.partition(":")
        try:
            bounds[name] = float(low), float(high)
        except ValueError:
            raise InputError(f"--bound is '{text}', but must be NAME=LOW:HIGH in SI units, e.g. {example}") from None
    return bounds


def print_identification(result: IdentificationResult, out: Path) -> None:
    """Print parameters with intervals and verdicts, then verdict, advice and warnings.

    Args:
        result: The identification.
        out: Folder of its files.
    """
    from flexros.identify.report.files import FIGURES, REPORT, ROBOT
    from flexros.identify.report.verdict import advice, kept_text, verdict

    console.print(parameter_table(result, console.width))
    say(verdict(result))
    if result.bias_signs:
        say(f"Signs of a model-form error: {'; '.join(result.bias_signs)}")
    for direction in result.identifiability.directions:
        say(direction.sentence)
    for sentence in filter(None, (advice(result), kept_text(result))):
        say(sentence)
    for warning in result.warnings:
        say(f"warning: {warning}")
    say(f"Identified robot: {out / ROBOT}; report: {out / REPORT}; figures: {out / FIGURES}")
