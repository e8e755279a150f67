"""Write the report of controllers on the multivariable benchmark."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.control_loops import control_loops
from flexros.analysis.report.loop import loop_table
from flexros.atomic_file import write_result
from flexros.benchmark.multivariable.tables import motion_demand_rows, motion_rows
from flexros.benchmark.report.run_picture import NominalRun, ShownSignal, run_picture
from flexros.control.design.methods.base import DesignProblem
from flexros.report.base import Folded, Paragraph, Picture, TextTable, Tiles
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.multivariable.evaluate import MotionBenchmark, MotionResult
    from flexros.benchmark.tables import Row
    from flexros.report.base import Block

SCALE = (
    "A benchmark of several axes by the rules of that of Moberg (2007), Paper C, which the thesis asks for (section "
    "6.2). All its numbers are chosen."
)
_MOST_POINTS = 4000
"""Samples of a curve [1] (chosen)."""


def write_motion_report(
    benchmark: MotionBenchmark,
    controllers: Sequence[BenchmarkController],
    results: Sequence[MotionResult],
    file: Path,
) -> None:
    """Write tables of cost, demands and measures, runs of the nominal model, and the margins of its loops.

    Args:
        benchmark: The benchmark.
        controllers: The controllers.
        results: Their results, in the same order.
        file: The HTML file; an existing one is replaced when the new one is complete.

    Raises:
        InputError: The file cannot be written.
    """
    names = tuple(result.name for result in results)
    tables = motion_rows(results)
    cost = _table(tables.pop("cost"), names, "Cost V.")
    demands = _table(motion_demand_rows(results), names, "Demands; eigenvalues are those of the worst loop.")
    measures = tuple(_table(rows, names, f"{heading}, mean over the seeds.") for heading, rows in tables.items())
    chapters = [
        Chapter("", _summary(results)),
        Chapter("Cost", (Paragraph(SCALE), cost)),
        Chapter("Demands", (demands,)),
        Chapter("Nominal model in time", (_run_picture(benchmark, controllers),)),
        *(Chapter(f"Loops of {one.name}", _loops(benchmark, one)) for one in controllers),
        Chapter("Measures", (Folded("Deflections, settling times and torques of all model sets", measures),)),
    ]
    title = f"Multivariable benchmark on {benchmark.problem.name}"
    seeds = ", ".join(map(str, results[0].seeds))
    write_result(file, page_html(title, f"{', '.join(names)}; seeds {seeds}", chapters), "report")


def _summary(results: Sequence[MotionResult]) -> tuple[Block, ...]:
    best = min(results, key=lambda result: result.cost)
    missed = [demand.name for demand in best.demands if not demand.passed]
    text = f"{best.name}: {'costs least, ' if len(results) > 1 else ''}V = {number(best.cost, 5)}; it " + (
        f"misses {'; '.join(missed)}." if missed else f"meets all {len(best.demands)} demands."
    )
    tiles = []
    for result in results:
        met = sum(demand.passed for demand in result.demands)
        tiles.append((result.name, number(result.cost, 5), "V", f"{met} of {len(result.demands)} demands met"))
    return (Paragraph(text, "lead"), Tiles(tuple(tiles)))


def _table(rows: Sequence[Row], names: tuple[str, ...], caption: str) -> TextTable:
    cells = tuple((row.name, row.unit, *row.values) for row in rows)
    return TextTable(("Measure", "Unit", *names), cells, caption, left=2)


def _run_picture(benchmark: MotionBenchmark, controllers: Sequence[BenchmarkController]) -> Picture:
    return run_picture(
        [_shown_run(benchmark, controller) for controller in controllers],
        ShownSignal("Distance of the tool from its undisturbed path", "distance [mm]", "mm"),
        ShownSignal("Largest torque of a motor", "torque [% of the motor's]", "%"),
        "The nominal model under all disturbances, with noise; compare Figures 9 and 10 of Paper C.",
    )


def _shown_run(benchmark: MotionBenchmark, controller: BenchmarkController) -> NominalRun:
    run = benchmark.nominal_run(controller)
    every = max(1, len(run.time) // _MOST_POINTS)
    distance, torque = np.asarray(run.distance[::every]), np.asarray(run.torque[::every])
    return NominalRun(controller.name, run.time[::every], distance, torque)


def _loops(benchmark: MotionBenchmark, controller: BenchmarkController) -> tuple[Block, ...]:
    """Return the margins of C2 with the nominal model at home."""
    (loop,) = control_loops(
        controller.perturbed, DesignProblem.of(benchmark.problem.robot, sample_time=benchmark.sample_time)
    )
    return loop_table(loop.margins)
