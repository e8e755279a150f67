"""Write the report of controllers on the feedback benchmark."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.atomic_file import write_result
from flexros.benchmark.models import NOMINAL, RULES, set_values
from flexros.benchmark.published import PUBLISHED, PUBLISHED_V1, SOLUTIONS
from flexros.benchmark.report.run_picture import NominalRun, ShownSignal, run_picture
from flexros.benchmark.tables import MEASURE_NAMES, Row, cost_rows, demand_rows, measure_rows, measure_values
from flexros.control.linear_controller import linear_controller
from flexros.report.base import Folded, Paragraph, Picture, TextTable, Tiles
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html
from flexros.report.theme import LOGARITHMIC, curve, run_colour, stacked

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.evaluate import BenchmarkResult, FeedbackBenchmark
    from flexros.benchmark.recorded import RecordedRun
    from flexros.control.context import LoopContext
    from flexros.report.base import Block

SCALE = (
    "Plant, kinds of disturbances, measures and demands are those of Moberg (2007), Paper C. Its model sets, noise, "
    "and times and sizes of the disturbances are not public: those here were chosen, and the weights inferred from its "
    "tables. The published figures are on the same scale and are not reproduced here."
)


def write_report(
    benchmarks: Sequence[FeedbackBenchmark],
    controllers: Sequence[BenchmarkController],
    results: Sequence[BenchmarkResult],
    file: Path,
) -> None:
    """Write tables of cost, measures and demands, runs of the nominal model and frequency responses.

    Args:
        benchmarks: The benchmark with the sensors of each controller.
        controllers: The controllers.
        results: Their results, in the same order.
        file: The HTML file; an existing one is replaced when the new one is complete.

    Raises:
        InputError: The file cannot be written.
    """
    names = tuple(result.name for result in results)
    runs = [_nominal_run(*all_of) for all_of in zip(benchmarks, controllers, results, strict=True)]
    contexts = [benchmark.context for benchmark in benchmarks]
    chapters = [
        Chapter("", _summary(results)),
        Chapter("Cost", (Paragraph(SCALE), _table(cost_rows(results), names, "Cost V and its parts."), _published())),
        Chapter("Demands", (_table(demand_rows(results), names, "Demands; eigenvalues are those of the worst loop."),)),
        Chapter("Nominal model in time", (_run_picture(runs),)),
        Chapter("Frequency responses", (_response_picture(controllers, contexts),)),
        Chapter("Measures", (_measures(results, names),)),
    ]
    noise = f"noise {results[0].noise:g} rad, seeds {', '.join(map(str, results[0].seeds))}"
    write_result(file, page_html("Feedback benchmark", f"{', '.join(names)}; {noise}", chapters), "report")


def write_log_report(run: RecordedRun, file: Path) -> None:
    """Write measures and pictures of a recorded run of the nominal model.

    Args:
        run: The run.
        file: The HTML file; an existing one is replaced when the new one is complete.

    Raises:
        InputError: The file cannot be written.
    """
    rows = tuple(
        Row(name, unit, (number(value, 4),))
        for (name, unit), value in zip(MEASURE_NAMES, measure_values(run.measures), strict=True)
    )
    cost = f"{run.name}: V of the nominal model = {number(run.measures.cost, 5)}."
    lead = Paragraph(f"{cost} The demands and the other models need the controller itself, as a file.", "lead")
    recorded = _run(run.name, run.sample_time, run.deflection, run.command)
    chapters = [
        Chapter("", (lead,)),
        Chapter("Nominal model in time", (_run_picture([recorded]),)),
        Chapter("Measures", (Paragraph(SCALE), _table(rows, (run.name,), "Measures of the nominal model."))),
    ]
    write_result(file, page_html("Feedback benchmark", f"recorded run {run.name}", chapters), "report")


def _summary(results: Sequence[BenchmarkResult]) -> tuple[Block, ...]:
    """Return the headline: the lowest cost, and which demands are missed; a tile for each controller."""
    best = min(results, key=lambda result: result.cost)
    missed = [demand.name for demand in best.demands if not demand.passed]
    words = "costs least, " if len(results) > 1 else ""
    text = f"{best.name}: {words}V = {number(best.cost, 5)}; it " + (
        f"misses {', '.join(missed)}." if missed else f"meets all {len(best.demands)} demands."
    )
    tiles = tuple(
        (result.name, number(result.cost, 5), "V", f"{sum(d.passed for d in result.demands)} of "
         f"{len(result.demands)} demands met")
        for result in results
    )  # fmt: skip
    return (Paragraph(text, "lead"), Tiles(tiles))


def _measures(results: Sequence[BenchmarkResult], names: tuple[str, ...]) -> Folded:
    tables = [
        _table(measure_rows(results, name), names, f"Worst measures of {name}, mean over the seeds.") for name in RULES
    ]
    return Folded(f"Deflections, settling times and torques of {', '.join(RULES)}, and the published ones of M1",
                  (*tables, _published_measures()))  # fmt: skip


def _nominal_run(benchmark: FeedbackBenchmark, controller: BenchmarkController, result: BenchmarkResult) -> NominalRun:
    deflection, command = benchmark.simulation.run(
        controller.nominal,
        set_values(benchmark.robot, NOMINAL),
        lambda _, z, u: (z.copy(), u.copy()),
        noise=result.noise,
        seeds=result.seeds[:1],
    )[0][0]
    return _run(controller.name, benchmark.context.sample_time, deflection, command)


def _table(rows: Sequence[Row], names: tuple[str, ...], caption: str) -> TextTable:
    return TextTable(
        ("Measure", "Unit", *names), tuple((row.name, row.unit, *row.values) for row in rows), caption, left=2
    )


def _published() -> TextTable:
    rows = tuple(
        (name, *(f"{PUBLISHED[solution][index]:g}" for solution in PUBLISHED))
        for index, name in enumerate(("V of nominal", "V of M1", "V of M2", "V"))
    )
    header = ("Measure", *(f"{solution}: {SOLUTIONS[solution]}" for solution in PUBLISHED))
    return TextTable(header, rows, "Published costs (Paper C, Table 2), on the same scale, with other model sets.")


def _published_measures() -> TextTable:
    rows = tuple(
        (name, unit, *(f"{PUBLISHED_V1[solution][index]:g}" for solution in PUBLISHED_V1))
        for index, (name, unit) in enumerate(MEASURE_NAMES)
    )
    return TextTable(
        ("Measure", "Unit", *PUBLISHED_V1),
        rows,
        "Published measures of M1 (Paper C, Table 1), other model sets.",
        left=2,
    )


def _run_picture(runs: Sequence[NominalRun]) -> Picture:
    return run_picture(
        runs,
        ShownSignal("Tool deflection", "deflection [mm]", "mm"),
        ShownSignal("Motor torque", "torque [Nm]", "Nm"),
        "The nominal model under all disturbances; compare Figures 9 and 10 of Paper C.",
    )


def _run(name: str, sample_time: float, deflection: FloatArray, command: FloatArray) -> NominalRun:
    time = np.asarray(np.arange(len(deflection)) * sample_time, dtype=float)
    return NominalRun(name, time, deflection, command)


def _response_picture(controllers: Sequence[BenchmarkController], contexts: Sequence[LoopContext]) -> Picture:
    frequency: FloatArray = np.geomspace(0.05, 0.499 / contexts[0].sample_time, 600)
    figure = stacked(("Magnitude", "Phase"), height=240)
    z = np.exp(2j * np.pi * frequency * contexts[0].sample_time)
    for index, (controller, context) in enumerate(zip(controllers, contexts, strict=True)):
        linear = linear_controller(controller.perturbed, context)
        entry = linear.state_measured[:, 0]
        memory = np.linalg.solve(
            z[:, None, None] * np.eye(len(entry)) - linear.state_step,
            np.broadcast_to(entry[:, None], (len(z), len(entry), 1)),
        )
        response = -(linear.from_state[0] @ memory[..., 0].T + linear.from_measured[0, 0])
        magnitude, phase = 20 * np.log10(np.abs(response)), np.degrees(np.unwrap(np.angle(response)))
        for row, (values, unit) in enumerate(((magnitude, "dB"), (phase, "degrees")), start=1):
            line = curve(
                frequency, values, controller.name, run_colour(index), hover=f"%{{x:.4g}} Hz: %{{y:.4g}} {unit}",
                legend=row == 1,
            )  # fmt: skip
            figure.add_trace(line, row=row, col=1)
    figure.update_xaxes(LOGARITHMIC)
    figure.update_yaxes(title_text="dB of Nm/rad", row=1, col=1)
    figure.update_yaxes(title_text="degrees", row=2, col=1)
    figure.update_xaxes(title_text="frequency [Hz]", row=2, col=1)
    return Picture(figure, "Controllers C2, from motor position error to torque; compare Figures 15 and 16 of Paper C.")
