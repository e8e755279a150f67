"""Tables of results, the same for terminal, report and page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.benchmark.models import RULES
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.benchmark.evaluate import BenchmarkResult
    from flexros.benchmark.measures import Measures


@dataclass(frozen=True)
class Row:
    """A row of a table: name, unit, and one text per controller."""

    name: str
    unit: str
    values: tuple[str, ...]


MEASURE_NAMES = (
    *((f"e{number}", "mm") for number in range(1, 9)),
    *((f"Ts{number}", "s") for number in range(1, 5)),
    ("T_NOISE", "Nm"),
    ("T_MAX", "Nm"),
    ("T_RMS", "Nm"),
)
"""Names and units of the measures in the order of `measure_values`."""


def measure_values(measures: Measures) -> tuple[float, ...]:
    """Return all measures in the order of `MEASURE_NAMES`."""
    rest = (measures.noise_torque, measures.largest_torque, measures.rms_torque)
    return (*measures.deflection.tolist(), *measures.settling.tolist(), *rest)


def cost_rows(results: Sequence[BenchmarkResult]) -> tuple[Row, ...]:
    """Return V, the costs of the sets and the number of demands met."""
    rows = [Row("V", "1", tuple(number(result.cost, 5) for result in results))]
    for name in RULES:
        rows.append(Row(f"V of {name}", "1", tuple(number(result.measures[name].cost, 5) for result in results)))
    met = tuple(f"{sum(d.passed for d in result.demands)} of {len(result.demands)}" for result in results)
    return (*rows, Row("demands met", "", met))


def measure_rows(results: Sequence[BenchmarkResult], name: str) -> tuple[Row, ...]:
    """Return the worst measures of a model set."""
    columns = [measure_values(result.measures[name]) for result in results]
    return tuple(
        Row(measure, unit, tuple(number(column[index], 4) for column in columns))
        for index, (measure, unit) in enumerate(MEASURE_NAMES)
    )


def demand_rows(results: Sequence[BenchmarkResult]) -> tuple[Row, ...]:
    """Return the value of every demand, with "missed" where it is not met."""
    rows = []
    for index, demand in enumerate(results[0].demands):
        found = [result.demands[index] for result in results]
        texts = tuple(demand_text(entry.value, entry.limit) + ("" if entry.passed else " missed") for entry in found)
        rows.append(Row(f"{demand.name} < {demand.limit:g}", demand.unit, texts))
    return tuple(rows)


def demand_text(value: float, limit: float) -> str:
    """Return the value of a demand; an eigenvalue near its limit 1 with five decimals."""
    return f"{value:.5f}" if limit == 1.0 else number(value, 3)
