"""Tables of the multivariable benchmark, the same for terminal and page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.benchmark.models import RULES
from flexros.benchmark.multivariable.problem import problem_named
from flexros.benchmark.tables import Row
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.benchmark.multivariable.evaluate import MotionResult


def motion_rows(results: Sequence[MotionResult]) -> dict[str, list[Row]]:
    """Return the rows of cost and measures by heading.

    Args:
        results: Results of controllers on one robot.
    """
    windows = problem_named(results[0].robot).windows
    settling = [window for window in windows if window.settles]
    tables = {"cost": [Row("V", "1", tuple(number(result.cost, 4) for result in results))]}
    for name in RULES:
        found = [result.measures[name] for result in results]
        rows = [Row("V of the set", "1", tuple(number(one.cost, 4) for one in found))]
        for place, window in enumerate(windows):
            rows.append(Row(f"e, {window.name}", "mm", tuple(number(float(one.deflection[place]), 3) for one in found)))
        for place, window in enumerate(settling):
            rows.append(Row(f"Ts, {window.name}", "s", tuple(number(float(one.settling[place]), 3) for one in found)))
        rows.append(Row("T_NOISE", "%", tuple(number(one.noise_torque, 3) for one in found)))
        rows.append(Row("T_MAX", "%", tuple(number(one.largest_torque, 3) for one in found)))
        tables[f"worst of {name}"] = rows
    return tables


def motion_demand_rows(results: Sequence[MotionResult]) -> list[Row]:
    """Return a row of each demand: value and verdict of every controller."""
    rows = []
    for place, demand in enumerate(results[0].demands):
        limit = f"{demand.name} < {demand.limit:g}"
        cells = [result.demands[place] for result in results]
        texts = (f"{_value(cell.value)} {'met' if cell.passed else 'missed'}" for cell in cells)
        rows.append(Row(limit, demand.unit, tuple(texts)))
    return rows


def _value(value: float) -> str:
    return number(value, 3) if not 0.9 < value < 1.1 or not np.isfinite(value) else f"{value:.5f}"
