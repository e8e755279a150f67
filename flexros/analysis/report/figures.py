"""Section: the table of all figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.analysis.figures_table import figure_rows
from flexros.report.base import AbstractSection, Block, Folded, TextTable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.run_analysis import Analysis


_COLUMNS = 4
"""Runs per table."""


class FiguresSection(AbstractSection["Sequence[Analysis]"]):
    """Every figure of every run, the same rows as in the terminal."""

    title: ClassVar[str] = "All figures"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the table, split into parts of a few runs so that it fits a page."""
        parts = [analyses[first : first + _COLUMNS] for first in range(0, len(analyses), _COLUMNS)]
        tables = tuple(map(_table, parts))
        figures = sum(len(row) > 1 for row in tables[0].rows)
        runs = "one run" if len(analyses) == 1 else f"{len(analyses)} runs"
        return (Folded(f"{figures} figures of {runs}", tables),)


def _table(analyses: Sequence[Analysis]) -> TextTable:
    rows: list[tuple[str, ...]] = []
    group = ""
    for row in figure_rows(analyses):
        if row.group != group:
            group = row.group
            rows.append((group,))
        rows.append((row.name, row.unit, *row.values))
    header = ("Figure", "Unit", *(analysis.label for analysis in analyses))
    return TextTable(header, tuple(rows), "All figures; they are computed from every sample.", left=2)
