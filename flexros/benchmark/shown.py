"""Results of the feedback benchmark as tables (pandas), as a picture, and in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.benchmark.models import RULES
from flexros.benchmark.tables import MEASURE_NAMES, Row, cost_rows, demand_rows, measure_rows, measure_values

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.benchmark.evaluate import BenchmarkResult


def measures_frame(results: Sequence[BenchmarkResult]) -> pd.DataFrame:
    """Return cost V, its parts and the worst measures of each model set, a column per controller.

    Args:
        results: Results of controllers.

    Returns:
        Numbers by set and measure; the set "all" holds V and the number of demands missed.
    """
    import pandas as pd

    columns: dict[str, dict[tuple[str, str, str], float]] = {}
    for result in results:
        column = {
            ("all", "V", "1"): result.cost,
            ("all", "demands missed", "1"): float(sum(not demand.passed for demand in result.demands)),
        }
        for name in RULES:
            column[name, "V", "1"] = result.measures[name].cost
            values = measure_values(result.measures[name])
            column |= {(name, *key): value for key, value in zip(MEASURE_NAMES, values, strict=True)}
        columns[result.name] = column
    frame = pd.DataFrame(columns)
    frame.index.names = ["set", "measure", "unit"]
    return frame


def costs_figure(results: Sequence[BenchmarkResult]) -> go.Figure:
    """Draw the weighted costs of the model sets as stacked bars, one per controller; their sum is V."""
    import plotly.graph_objects as go

    from flexros.report.theme import run_colour, stacked

    figure = stacked(["Cost V and its parts"], height=90 + 46 * len(results))
    for index, (name, rule) in enumerate(RULES.items()):
        costs = [rule.weight * result.measures[name].cost for result in results]
        names = [result.name for result in results]
        figure.add_trace(
            go.Bar(
                x=costs, y=names, orientation="h", name=f"{name}, weight {rule.weight:g}",
                marker={"color": run_colour(index)}, hovertemplate="%{y}: %{x:.4g}<extra>" + name + "</extra>",
            )
        )  # fmt: skip
    figure.update_layout(barmode="stack")
    figure.update_yaxes(autorange="reversed", automargin=True)
    figure.update_xaxes(title_text="V")
    return figure


def results_html(results: Sequence[BenchmarkResult]) -> str:
    """Show costs, demands and measures of the nominal model in a notebook."""
    from flexros.benchmark.models import NOMINAL
    from flexros.report.base import TextTable
    from flexros.report.notebook import notebook_html

    names = tuple(result.name for result in results)

    def table(rows: Sequence[Row], caption: str) -> TextTable:
        cells = tuple((row.name, row.unit, *row.values) for row in rows)
        return TextTable(("", "unit", *names), cells, caption, left=2)

    blocks = (
        table(cost_rows(results), "Cost V = 0.6 V_nominal + V_1 + 0.3 V_2, and the demands met."),
        table(demand_rows(results), "Demands; the worst of all models.") if results[0].demands else table((), ""),
        table(measure_rows(results, NOMINAL), "Measures of the nominal model, mean over the seeds."),
    )
    return notebook_html("Feedback benchmark", blocks)
