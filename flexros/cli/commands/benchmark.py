"""Command that evaluates controllers on the feedback benchmark."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.evaluate import BenchmarkResult, FeedbackBenchmark
    from flexros.benchmark.multivariable.evaluate import MotionResult
    from flexros.benchmark.tables import Row

MOST_COLUMNS = 4
"""Controllers that are shown side by side [1] (chosen)."""


def benchmark(
    controller: list[str] = typer.Argument(
        None,
        help="Built-in controllers, YAML or Python files, or one log of the scenario feedback_benchmark; none: list.",
    ),
    noise: float = typer.Option(3e-4, "--noise", help="Standard deviation of the measurement noise [rad]; 0 for none."),
    seeds: str = typer.Option("1,2,3,4,5", "--seeds", help="Seeds of the noise, over which the measures are averaged."),
    on: str = typer.Option(
        "", "--on", help="Multivariable benchmark on a robot with a moving reference, e12 or six_axis, instead."
    ),
    report: Path = typer.Option(None, "--report", help="Write an HTML report that opens offline."),
    out: Path = typer.Option(None, "--out", help="Write the results to this JSON file."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Evaluate controllers on the feedback benchmark of Paper C: cost V, measures and demands of 21 models."""
    if on:
        _on_robot(on, controller or [], noise, seeds, report, out, as_json)
        return
    from flexros.benchmark.controllers import controller_names, load_controller
    from flexros.benchmark.evaluate import FeedbackBenchmark, check_noise
    from flexros.benchmark.recorded import is_recording

    if not controller:
        _list([load_controller(name) for name in controller_names()], as_json)
        return
    if len(controller) == 1 and is_recording(controller[0]):
        _show_log(Path(controller[0]), report, out, as_json)
        return
    numbers = _seeds(seeds)
    check_noise(noise, numbers)
    loaded = [load_controller(name) for name in controller]
    names = [one.name for one in loaded]
    if len(set(names)) < len(names):
        raise InputError(f"controllers {', '.join(names)} do not all have names of their own; rename a file")
    benches = {one.sensors: FeedbackBenchmark(one.sensors) for one in loaded}
    results = _evaluated(benches, loaded, noise, numbers)
    if report:
        from flexros.benchmark.report.write import write_report

        write_report([benches[one.sensors] for one in loaded], loaded, results, report)
    _show(_print_results, results, report, out, as_json)


def _show(
    print_results: Callable[[Sequence[Any]], None],
    results: Sequence[BenchmarkResult | MotionResult],
    report: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Print results, one alone without a list in JSON; write them to a file where one is given."""
    every = [result.as_dict() for result in results]
    content = every[0] if len(every) == 1 else every
    if out:
        _write_results(out, content)
    if as_json:
        print_json(content)
        return
    print_results(results)
    _name_files(report, out)


def _name_files(report: Path | None, out: Path | None) -> None:
    for file, what in ((report, "report"), (out, "results")):
        if file:
            say(f"{what}: {file}")


def _write_results(out: Path, content: Any) -> None:
    from flexros.atomic_file import write_result
    from flexros.json_text import json_text

    write_result(out, json_text(content), "results")


def _evaluated(
    benches: Mapping[tuple[str, ...], FeedbackBenchmark],
    loaded: Sequence[BenchmarkController],
    noise: float,
    seeds: tuple[int, ...],
) -> list[BenchmarkResult]:
    from flexros.benchmark.models import RULES

    results = []
    steps = len(RULES) + 1  # the runs of each model set, then the demands
    with progress_bar() as bar:
        task = bar.add_task("", total=steps * len(loaded))
        for number, one in enumerate(loaded):
            began = count(steps * number)

            def tell(step: str, name: str = one.name, began: Iterator[int] = began) -> None:
                bar.update(task, description=f"{name}: {step}", completed=next(began))

            results.append(benches[one.sensors].evaluate(one, noise=noise, seeds=seeds, progress=tell))
            bar.update(task, completed=steps * (number + 1))
    return results


def _on_robot(
    on: str, names: Sequence[str], noise: float, seeds: str, report: Path | None, out: Path | None, as_json: bool
) -> None:
    """Evaluate controllers on the multivariable benchmark."""
    from flexros.benchmark.evaluate import check_noise
    from flexros.benchmark.multivariable.evaluate import (
        MotionBenchmark,
        load_motion_controller,
        motion_controller_names,
    )
    from flexros.benchmark.multivariable.problem import problem_named
    from flexros.benchmark.simulation import NOISE

    problem = problem_named(on)
    if noise not in (0.0, NOISE):
        raise InputError(f"the noise is {noise} rad, allowed on {on} is 0 or that of its robot file", "noise")
    numbers = _seeds(seeds)
    check_noise(noise, numbers)
    loaded = [load_motion_controller(problem, name) for name in names or motion_controller_names(problem)]
    if not names:
        _list(loaded, as_json)
        return
    bench, results = MotionBenchmark(problem), []
    with progress_bar() as bar:
        task = bar.add_task(f"models of {on}", total=len(loaded))
        for done, one in enumerate(loaded, start=1):
            results.append(bench.evaluate(one, noise=noise > 0.0, seeds=numbers))
            bar.update(task, completed=done)
    if report:
        from flexros.benchmark.report.motion import write_motion_report

        write_motion_report(bench, loaded, results, report)
    _show(_print_motion, results, report, out, as_json)


def _print_motion(results: Sequence[MotionResult]) -> None:
    from flexros.benchmark.multivariable.tables import motion_demand_rows, motion_rows

    if len(results) > MOST_COLUMNS:
        _print_ranking(results)
        return
    names = [result.name for result in results]
    for heading, rows in motion_rows(results).items():
        console.print(_table(heading, names, rows))
    console.print(_table("demand", names, motion_demand_rows(results)))


def _show_log(path: Path, report: Path | None, out: Path | None, as_json: bool) -> None:
    """Print the measures of a recorded run of the nominal model, and write its files."""
    from flexros.benchmark.recorded import recorded_run
    from flexros.benchmark.tables import MEASURE_NAMES, measure_values

    run = recorded_run(path)
    measures = run.measures
    content = {"controller": path.name, "sets": {"nominal": measures.as_dict()}}
    if report:
        from flexros.benchmark.report.write import write_log_report

        write_log_report(run, report)
    if out:
        _write_results(out, content)
    if as_json:
        print_json(content)
        return
    table = Table("nominal", "unit", path.name)
    for (name, unit), value in zip(MEASURE_NAMES, measure_values(measures), strict=True):
        table.add_row(name, unit, f"{value:.4g}")
    table.add_row("V", "1", f"{measures.cost:.5g}")
    console.print(table)
    _name_files(report, out)


def _list(loaded: Sequence[BenchmarkController], as_json: bool) -> None:
    """Show names and descriptions of controllers."""
    if as_json:
        print_json([{"name": one.name, "description": one.description} for one in loaded])
        return
    table = Table("controller", "description")
    for one in loaded:
        table.add_row(one.name, one.description)
    console.print(table)


def _print_ranking(results: Sequence[BenchmarkResult | MotionResult]) -> None:
    """Print a line per controller, the lowest cost first: side by side, many do not fit a terminal."""
    from flexros.benchmark.models import RULES

    table = Table("controller", "V", *(f"V of {name}" for name in RULES), "demands met")
    missed = []
    for result in sorted(results, key=lambda result: result.cost):
        costs = [f"{result.measures[name].cost:.1f}" for name in RULES]
        late = [demand.name for demand in result.demands if not demand.passed]
        met = f"{len(result.demands) - len(late)} of {len(result.demands)}"
        table.add_row(result.name, f"{result.cost:.2f}", *costs, met)
        missed += [f"{result.name} misses {'; '.join(late)}"] if late else []
    console.print(table)
    for line in missed:
        say(line)
    say(f"for the measures of each: --out, or at most {MOST_COLUMNS} controllers")


def _print_results(results: Sequence[BenchmarkResult]) -> None:
    from flexros.benchmark.models import RULES
    from flexros.benchmark.tables import cost_rows, demand_rows, measure_rows

    if len(results) > MOST_COLUMNS:
        _print_ranking(results)
        return
    names = [result.name for result in results]
    console.print(_table("cost", names, cost_rows(results)))
    for name in RULES:
        console.print(_table(f"worst of {name}", names, measure_rows(results, name)))
    console.print(_table("demand", names, demand_rows(results)))


def _table(heading: str, names: Sequence[str], rows: Sequence[Row]) -> Table:
    table = Table(heading, "unit")
    for name in names:
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(row.name, row.unit, *row.values)
    return table


def _seeds(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"the seeds are '{text}', allowed are whole numbers with commas, e.g. 1,2,3", "seeds"
        ) from None
