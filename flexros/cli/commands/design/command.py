"""Command that designs a controller for a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from flexros.cli.commands.design.loops import show_loops
from flexros.cli.commands.design.tuning import SEED, STEP, STRUCTURE, Tuning, first_line, tuned
from flexros.cli.commands.robots import parse_numbers
from flexros.cli.model import ROBOT, linear_robot
from flexros.cli.options import names_in
from flexros.cli.output import print_json, say
from flexros.cli.progress import working
from flexros.config.settings import validate
from flexros.errors import InputError, argument_named, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.methods.base import AbstractDesignMethod, DesignProblem
    from flexros.robot import Robot

MARGINS = "margins"
"""In place of a method: no design, for a given controller."""


def design(
    method: str = typer.Argument(None, help="Method of design; without one, methods and their choices are listed."),
    model: str = typer.Option("four_mass", "--model", help=ROBOT),
    choice: list[str] = typer.Option([], "--set", help="Choice of the method, NAME=VALUE; repeatable."),
    q: list[str] = typer.Option([], "--q", help="Pose, arm coordinates with commas [rad or m]; repeatable."),
    models: str = typer.Option("", "--models", help="Model sets of the benchmark as further plants, e.g. M1,M2."),
    tune: int = typer.Option(0, "--tune", help="Laws tried per stage when tuned on the feedback benchmark; 0: not."),
    step: float = typer.Option(STEP, "--step", help="First step of the search, in logarithms of the numbers [1]."),
    seed: int = typer.Option(SEED, "--seed", help="Seed of the search."),
    start: Path = typer.Option(None, "--start", help="Controller file from whose parameters the search starts."),
    only: str = typer.Option("", "--only", help="Tune only C1 or C2; the other one is kept from --start."),
    controller: str = typer.Option("", "--controller", help="For margins: scenario, or controller of the benchmark."),
    out: Path = typer.Option(None, "--out", help="Write the controller file."),
    report: Path = typer.Option(None, "--report", help="Write Bode, Nyquist and step pictures and margins as HTML."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Design a controller for a robot over its spring range and poses, and show the margins of its loops."""
    from flexros.benchmark.tuning import controller_text, structure_of, write_controller
    from flexros.control.design.methods.base import DesignProblem, design_methods

    methods = design_methods()
    if not method:
        _list_methods(methods, as_json)
        return
    if method not in (*methods, STRUCTURE, MARGINS):
        raise unknown_name("method", method, (*methods, STRUCTURE, MARGINS))
    if method == MARGINS and out:
        raise InputError(f"margins designs no controller that {out} could hold; leave it out", "out")
    settings = _choices(choice)
    figures: dict[str, float] = {}
    if method == MARGINS:
        laws, problem = _given(controller, model, q)
    else:
        robot = _robot_with(model, structure_of(settings).sensors if method == STRUCTURE else ())
        names, values = _further_plants(robot, models)
        poses = [parse_numbers(text, "--q") for text in q]
        problem = DesignProblem.of(robot, poses, names=names, values=values)
        tuning = Tuning(tune, step, seed, start, only)
        made_by = _command(method, model, choice, q, models, tuning)
        if method == STRUCTURE or tune:
            laws, text = tuned(method, settings, problem, tuning, made_by)
        else:
            chosen = validate(methods[method], settings, f"method {method}")
            with working(f"designing by {method}"):
                found = chosen.design(problem)
            laws, figures = {"controller": found.law()}, dict(found.figures)
            text = controller_text(first_line(type(chosen)), made_by, laws)
        if out:
            write_controller(out, text)
    what = controller if method == MARGINS else method
    show_loops(laws, problem, figures, report, as_json, f"Loops of {what} on {problem.robot.name}")
    if out and not as_json:
        say(f"controller: {out}")


def _list_methods(methods: Mapping[str, type[AbstractDesignMethod]], as_json: bool) -> None:
    """List the methods with their choices."""
    described = {
        name: {
            "description": first_line(method),
            "choices": {key: str(field.description) for key, field in method.model_fields.items()},
        }
        for name, method in methods.items()
    }
    structure = {
        "sections": "second-order sections (lead-lag, notch) in series with the PID [1]",
        "lead_lags": "first-order lead-lags in series [1]",
        "acceleration": "1 for feedback of the tool acceleration, else 0 [1]",
        "acceleration_sections": "second-order sections in its path [1]",
    }
    text = "PID with lead-lags and second-order sections, tuned on the feedback benchmark (needs --tune)."
    described[STRUCTURE] = {"description": text, "choices": structure}
    described[MARGINS] = {"description": "No design: margins of a given controller (--controller).", "choices": {}}
    if as_json:
        print_json(described)
        return
    for name, entry in described.items():
        say(f"{name}: {entry['description']}")
        choices = entry["choices"]
        for key, description in choices.items() if isinstance(choices, dict) else ():
            say(f"    {key}: {description}")


def _robot_with(model: str, sensors: Sequence[str]) -> Robot:
    """Load a model; that of the benchmark gets the sensors that a controller of it uses."""
    from flexros.benchmark.models import ROBOT as BENCHMARK_ROBOT
    from flexros.benchmark.models import benchmark_robot

    return benchmark_robot(sensors) if sensors and model == BENCHMARK_ROBOT else linear_robot(model)


def _further_plants(robot: Robot, models: str) -> tuple[tuple[str, ...], FloatArray | None]:
    """Return names and values of the parameters of model sets, the nominal model first."""
    from flexros.benchmark.models import NOMINAL, PARAMETERS, RULES, set_values
    from flexros.benchmark.models import ROBOT as BENCHMARK_ROBOT

    wanted = [name for name in names_in(models) if name != NOMINAL]
    if not wanted:
        return (), None
    for name in wanted:
        if name not in RULES:
            raise unknown_name("model set", name, RULES, "--models")
    if robot.name != BENCHMARK_ROBOT:
        raise InputError(f"robot {robot.name} has no model sets, {BENCHMARK_ROBOT} has; give that one", "model")
    return PARAMETERS, np.vstack([set_values(robot, name) for name in (NOMINAL, *wanted)])


def _choices(texts: Sequence[str]) -> dict[str, float]:
    """Parse NAME=VALUE."""
    found: dict[str, float] = {}
    for text in texts:
        name, is_pair, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            is_pair = ""
        if not is_pair:
            raise InputError(f"'{text}' is no choice, allowed is NAME=NUMBER, e.g. walk=0.05; correct it", "choice")
    return found


def _given(controller: str, model: str, q: Sequence[str]) -> tuple[dict[str, AbstractControlLaw], DesignProblem]:
    """Return the laws of a scenario or of a controller of the benchmark, with the robot of the loop."""
    from flexros.benchmark.controllers import controller_names, load_controller
    from flexros.control.design.methods.base import DesignProblem
    from flexros.scenario.experiment import Experiment
    from flexros.scenario.scenario import load_scenario, scenario_names

    poses = [parse_numbers(text, "--q") for text in q]
    if controller in scenario_names():
        experiment = Experiment.prepare(load_scenario(controller))
        law: dict[str, AbstractControlLaw] = {"controller": experiment.scenario.controller}
        return law, DesignProblem.of(
            experiment.nominal, poses or [experiment.start], sample_time=experiment.sample_time
        )
    if not controller:
        raise InputError("no controller was given: name a scenario, or a controller file", "controller")
    with argument_named("controller"):
        if controller not in controller_names() and not controller.endswith((".yaml", ".yml", ".py")):
            raise unknown_name("controller", controller, (*controller_names(), *scenario_names()))
        given = load_controller(controller)
    laws = {"C1": given.nominal, "C2": given.perturbed}
    robot = _robot_with(model, given.sensors)
    return laws if given.nominal != given.perturbed else {"controller": given.nominal}, DesignProblem.of(robot, poses)


def _command(method: str, model: str, choice: Sequence[str], q: Sequence[str], models: str, tuning: Tuning) -> str:
    """Return the command that reproduces a design."""
    words = ["flexros design", method, f"--model {model}"]
    words += [f"--set {text}" for text in choice] + [f"--q={text}" for text in q]
    words += [f"--models {models}"] if models else []
    return " ".join(words + tuning.options)
