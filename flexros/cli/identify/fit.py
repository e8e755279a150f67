"""Command that fits parameters to frequency responses, and how an identification is printed."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexros.cli.identify.design import UNKNOWN, chosen_names
from flexros.cli.identify.table import parameter_table
from flexros.cli.model import linear_robot
from flexros.cli.output import console, print_json, progress_bar, say
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.result import IdentificationResult
    from flexros.identify.search import Found, SearchSettings
    from flexros.robot import Robot

BOUND = "Of a value [SI], NAME=LOW:HIGH (may be repeated); default: a factor of 10 either way."
"""Help of the option that bounds values."""


def fit(
    responses: Path = typer.Argument(help="File of frequency responses (netCDF), from: flexros identify frf."),
    model: str = typer.Option(..., "--model", help="Robot with its nominal values: shipped name or YAML."),
    out: Path = typer.Option(
        ...,
        "--out",
        help="Folder for identified.yaml, identification.json and report.html; those of an earlier fit are replaced.",
    ),
    unknown: list[str] = typer.Option([], "--unknown", help=UNKNOWN),
    estimator: str = typer.Option("LLS", "--estimator", help="LLS, LLSM (magnitude only) or NLS."),
    weights: str = typer.Option("combined", "--weights", help="Of the last fit: user, optimal or combined."),
    starts: int = typer.Option(20, "--starts", help="Number of starts, the first one at the nominal values."),
    seed: int = typer.Option(1, "--seed", help="Seed of the starts."),
    bound: list[str] = typer.Option([], "--bound", help=BOUND),
    scheduler: str = typer.Option("", "--scheduler", help="Address of a Dask scheduler whose workers fit."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Fit unknown parameters to measured frequency responses, from several starts."""
    from flexros.identify.frf.files.netcdf import load_responses
    from flexros.identify.report.files import write_identification
    from flexros.identify.result import identification_result
    from flexros.provenance import versions

    robot = linear_robot(model)
    names = chosen_names(robot, unknown)
    settings = search_settings(robot, names, estimator, weights, starts, seed, bound)
    measured = load_responses(responses)
    found = searched(robot, measured, names, settings, scheduler)
    provenance = {"responses": responses.name, "robot": robot.name, "seed": seed, "versions": versions()}
    result = identification_result(
        found.problem, found.fit, found.searched, warnings=found.warnings, provenance=provenance
    )
    write_identification(result, out, responses.name)
    if as_json:
        print_json(result.as_dict())
    else:
        print_identification(result, out)


def search_settings(
    robot: Robot,
    names: tuple[str, ...],
    estimator: str,
    weights: str,
    starts: int,
    seed: int,
    bound: list[str],
) -> SearchSettings:
    """Check the choices of a fit, before anything is measured for it.

    Args:
        robot: The robot with its nominal values.
        names: Unknown parameters.
        estimator: Its name.
        weights: Kind of the weights of the last fit.
        starts: Number of starts.
        seed: Seed of the starts.
        bound: Bounds of values, NAME=LOW:HIGH.

    Returns:
        The choices.

    Raises:
        InputError: One of them is not possible.
    """
    from flexros.identify.graybox.estimators import estimator_named
    from flexros.identify.graybox.parameter_scale import parameter_scale
    from flexros.identify.graybox.weights import weights_named
    from flexros.identify.search import SearchSettings

    estimator_named(estimator, "--estimator")
    weights_named(weights, "--weights")
    if starts < 1:
        raise InputError(f"--starts is {starts}: {starts} starts were asked for, but at least one is needed")
    if seed < 0:
        raise InputError(f"--seed is {seed}, but must be 0 or more")
    bounds = value_bounds(names, bound)
    parameter_scale(robot, names).bounds(bounds)
    return SearchSettings(estimator, weights, starts, seed, bounds)


def searched(
    robot: Robot,
    responses: Sequence[FrequencyResponse],
    names: tuple[str, ...],
    settings: SearchSettings,
    scheduler: str = "",
) -> Found:
    """Search for the parameters with a progress bar.

    Args:
        robot: The robot with its nominal values.
        responses: Measured responses.
        names: Unknown parameters.
        settings: How to search.
        scheduler: Address of a Dask scheduler; empty for threads of this process.

    Returns:
        What was found.

    Raises:
        InputError: Something is not possible, or there is no scheduler at the address.
    """
    from flexros.identify.search import search
    from flexros.scheduler import connected

    with ExitStack() as stack:
        client = stack.enter_context(connected(scheduler)) if scheduler else None
        bar = stack.enter_context(progress_bar())
        task = bar.add_task("fits", total=settings.starts)
        return search(robot, responses, names, settings, client, lambda done: bar.update(task, completed=done))


def value_bounds(names: Sequence[str], texts: list[str]) -> dict[str, tuple[float, float]]:
    """Read bounds of values, NAME=LOW:HIGH.

    Args:
        names: Unknown parameters.
        texts: What was given.

    Returns:
        Lower and upper bound [SI] by name.

    Raises:
        InputError: No such parameter, or no two numbers.
    """
    bounds = {}
    for text in texts:
        name, _, pair = text.partition("=")
        if name not in names:
            raise unknown_name("parameter to identify", name, names, "--bound")
        try:
            low, high = (float(part) for part in pair.split(":"))
        except ValueError:
            raise InputError(
                f"--bound is '{text}', but must be NAME=LOW:HIGH in SI units, e.g. {name}=1e4:1e6"
            ) from None
        bounds[name] = (low, high)
    return bounds


def print_identification(result: IdentificationResult, out: Path) -> None:
    """Print parameters with intervals and verdicts, then what the result rests on.

    Args:
        result: What was identified.
        out: Folder of its files.
    """
    from flexros.identify.report.files import FIGURES, REPORT, ROBOT
    from flexros.identify.report.verdict import advice, kept_text, verdict

    console.print(parameter_table(result, console.width))
    say(verdict(result))
    if result.bias_signs:
        say(f"Signs that the model lacks something: {'; '.join(result.bias_signs)}")
    for direction in result.identifiability.directions:
        say(direction.sentence)
    for told in filter(None, (advice(result), kept_text(result))):
        say(told)
    for warning in result.warnings:
        say(f"warning: {warning}")
    say(f"Identified robot: {out / ROBOT}; report: {out / REPORT}; figures: {out / FIGURES}")
