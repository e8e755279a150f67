"""Command that designs a controller for a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer
from rich.table import Table

from flexros.cli.commands.robots import parse_numbers
from flexros.cli.model import ROBOT, linear_robot
from flexros.cli.options import names_in
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_shown, working
from flexros.config.settings import validate
from flexros.errors import InputError, argument_named, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.benchmark.tuning import Tunable
    from flexros.config.settings import Settings
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.margins import LoopMargins
    from flexros.control.design.methods.base import AbstractDesignMethod, DesignProblem
    from flexros.robot import Robot

STRUCTURE, MARGINS = "structure", "margins"
"""Methods beside those of `flexros.control.design.methods`: a tuned structure, and none, for a given controller."""


def design(
    method: str = typer.Argument(None, help="Method of design; without one, methods and their choices are listed."),
    model: str = typer.Option("four_mass", "--model", help=ROBOT),
    choice: list[str] = typer.Option([], "--set", help="Choice of the method, NAME=VALUE; repeatable."),
    q: list[str] = typer.Option([], "--q", help="Pose, arm coordinates with commas [rad or m]; repeatable."),
    models: str = typer.Option("", "--models", help="Model sets of the benchmark as further plants, e.g. M1,M2."),
    tune: int = typer.Option(0, "--tune", help="Laws tried per stage when tuned on the feedback benchmark; 0: not."),
    step: float = typer.Option(0.3, "--step", help="First step of the search, in logarithms of the numbers [1]."),
    seed: int = typer.Option(1, "--seed", help="Seed of the search."),
    start: Path = typer.Option(None, "--start", help="Controller file from whose parameters the search starts."),
    only: str = typer.Option("", "--only", help="Tune only C1 or C2; the other one is kept from --start."),
    controller: str = typer.Option("", "--controller", help="For margins: scenario, or controller of the benchmark."),
    out: Path = typer.Option(None, "--out", help="Write the controller file."),
    report: Path = typer.Option(None, "--report", help="Write Bode, Nyquist and step pictures and margins as HTML."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Design a controller for a robot over its spring range and poses, and show the margins of its loops."""
    from flexros.benchmark.tuning import structure_of
    from flexros.control.design.methods.base import DesignProblem, design_methods

    methods = design_methods()
    if not method:
        _list_methods(methods, as_json)
        return
    if method not in (*methods, STRUCTURE, MARGINS):
        raise unknown_name("method", method, (*methods, STRUCTURE, MARGINS))
    settings = _choices(choice)
    figures: dict[str, float] = {}
    if method == MARGINS:
        laws, problem = _given(controller, model, q)
    else:
        robot = _robot_with(model, structure_of(settings).sensors if method == STRUCTURE else ())
        names, values = _further_plants(robot, models)
        poses = [parse_numbers(text, "--q") for text in q]
        problem = DesignProblem.of(robot, poses, names=names, values=values)
        if method == STRUCTURE or tune:
            made_by = _command(method, model, choice, q, models, tune, step, seed, start, only)
            laws, text = _tuned(method, settings, problem, tune, step, seed, start, only, made_by)
        else:
            chosen = validate(methods[method], settings, f"method {method}")
            with working(f"designing by {method}"):
                found = chosen.design(problem)
            laws, figures = {"controller": found.law()}, dict(found.figures)
            text = _text(
                method, chosen, laws, _command(method, model, choice, q, models, tune, step, seed, start, only)
            )
        if out:
            from flexros.benchmark.tuning import write_controller

            write_controller(out, text)
    what = controller if method == MARGINS else method
    _show(laws, problem, figures, report, as_json, f"Loops of {what} on {problem.robot.name}")
    if out and not as_json:
        say(f"controller: {out}")


def _show(
    laws: Mapping[str, AbstractControlLaw],
    problem: DesignProblem,
    figures: Mapping[str, float],
    report: Path | None,
    as_json: bool,
    title: str,
) -> None:
    """Print the margins of the loops, and write the report."""
    from flexros.analysis.control_loops import control_loops

    loops = {key: control_loops(law, problem) for key, law in laws.items()}
    if report:
        from flexros.analysis.report.loop import write_loop_report

        write_loop_report(loops, report, title=title)
    if as_json:
        print_json(
            {
                "figures": figures,
                "controllers": {
                    key: {
                        "order": len(of_law[0].controller.state_step),
                        "margins": [entry.as_dict() for loop in of_law for entry in loop.margins],
                    }
                    for key, of_law in loops.items()
                },
            }
        )
        return
    for name, value in figures.items():
        say(f"{name}: {value:.4g}")
    for key, of_law in loops.items():
        entries = [entry for loop in of_law for entry in loop.margins]
        console.print(_margin_table(key if len(loops) > 1 else "plant", entries))
    if report:
        say(f"report: {report}")


def _margin_table(heading: str, entries: Sequence[LoopMargins]) -> Table:
    table = Table(heading, "motor", "eigenvalue", "gain margin", "phase [deg]", "delay [ms]", "max |S|", "settling [s]")
    for entry in entries:
        table.add_row(
            entry.plant,
            str(entry.motor + 1),
            f"{entry.largest_eigenvalue:.5f}",
            f"{entry.gain_down:.2g}-{entry.gain_up:.3g}",
            f"{np.degrees(entry.phase):.1f}",
            f"{1e3 * entry.delay:.2f}",
            f"{entry.sensitivity:.3g}",
            f"{entry.settling:.3g}",
        )
    return table


def _list_methods(methods: Mapping[str, type[AbstractDesignMethod]], as_json: bool) -> None:
    """List the methods with their choices."""
    described = {
        name: {
            "description": (method.__doc__ or "").splitlines()[0],
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


def _tuned(
    method: str,
    settings: Mapping[str, float],
    problem: DesignProblem,
    tune: int,
    step: float,
    seed: int,
    start: Path | None,
    only: str,
    made_by: str,
) -> tuple[dict[str, AbstractControlLaw], str]:
    """Tune both controllers of a design on the benchmark; return them with the text of the controller file."""
    from flexros.benchmark.evaluate import FeedbackBenchmark
    from flexros.benchmark.models import ROBOT as BENCHMARK_ROBOT
    from flexros.benchmark.tuning import (
        PARTS,
        TunableMethod,
        controller_text,
        started_from,
        structure_of,
        structure_stages,
    )
    from flexros.benchmark.tuning import tune as tuned
    from flexros.control.design.methods.base import design_methods

    if tune < 1:
        raise InputError(f"{tune} laws per stage were given, but a structure is tuned; give at least one", "tune")
    if problem.robot.name != BENCHMARK_ROBOT:
        raise InputError(
            f"robot {problem.robot.name} is not that of the benchmark, {BENCHMARK_ROBOT}; give that one", "model"
        )
    if only and (only not in PARTS or not start):
        raise InputError(
            f"'{only}' alone is to be tuned, allowed is C1 or C2, with a controller to start from; correct it", "only"
        )
    stages: Sequence[Tunable]
    if method == STRUCTURE:
        structure = structure_of(settings)
        stages, first = (structure,) if start else structure_stages(structure), structure.start()
        what = (
            f"PID with {structure.text}, order {structure.order}, tuned on the cost V with the demands as constraints."
        )
    else:
        chosen = validate(design_methods()[method], settings, f"method {method}")
        one = TunableMethod(chosen, problem)
        stages, first = (one,), one.start()
        what = f"{(type(chosen).__doc__ or '').splitlines()[0]} Its weights are tuned on the cost V."
    known = {part: first | (started_from(start, key) if start else {}) for part, key in PARTS.items()}
    bench = FeedbackBenchmark(stages[-1].sensors)
    found = {}
    with progress_shown() as show:
        for number, (part, key) in enumerate(PARTS.items()):
            if only and part != only:
                found[key] = known[part]
                continue
            found[key] = tuned(
                bench, stages, known[part], part, evaluations=tune, step=step, seed=seed,
                progress=lambda text, share, number=number: show(text, (number + share) / len(PARTS)),  # type: ignore[misc]
            ).values  # fmt: skip
    laws = {key: stages[-1].law(values, problem.sample_time) for key, values in found.items()}
    return laws, controller_text(what, made_by, laws, found, stages[-1].sensors)


def _text(method: str, chosen: Settings, laws: Mapping[str, AbstractControlLaw], made_by: str) -> str:
    from flexros.benchmark.tuning import controller_text

    return controller_text((type(chosen).__doc__ or method).splitlines()[0], made_by, laws)


def _command(
    method: str,
    model: str,
    choice: Sequence[str],
    q: Sequence[str],
    models: str,
    tune: int,
    step: float,
    seed: int,
    start: Path | None,
    only: str,
) -> str:
    """Return the command that reproduces a design."""
    words = ["flexros design", method, f"--model {model}"]
    words += [f"--set {text}" for text in choice] + [f"--q={text}" for text in q]
    words += [f"--models {models}"] if models else []
    if tune:
        words += [
            f"--tune {tune}",
            *([f"--step {step:g}"] if step != 0.3 else []),
            *([f"--seed {seed}"] if seed != 1 else []),
        ]
    words += [f"--start {start}"] if start else []
    return " ".join(words + ([f"--only {only}"] if only else []))
