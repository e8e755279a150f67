"""Tables of analyses and comparisons for the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from rich.table import Table
from rich.text import Text

from flexros.analysis.comparison import HEADINGS
from flexros.analysis.figures_table import figure_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.comparison import Comparison
    from flexros.analysis.run_analysis import Analysis


def terminal_table(analyses: Sequence[Analysis]) -> Table:
    """Return the figures of one or several runs as a table with one column per run."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    rows = figure_rows(analyses)
    for heading in ("", "figure", "unit"):
        table.add_column(heading, no_wrap=heading != "figure", overflow="fold")
    for run, analysis in enumerate(analyses):
        # In a narrow terminal names are wrapped; numbers never are.
        width = max((len(row.values[run]) for row in rows), default=1)
        table.add_column(Text(analysis.label), justify="right", min_width=width, overflow="fold")
    group = ""
    for row in rows:
        table.add_row(*map(Text, (row.group if row.group != group else "", row.name, row.unit, *row.values)))
        group = row.group
    return table


def comparison_table(comparison: Comparison) -> Table:
    """Return measured and published path errors as a table, one row per method and case."""
    table = Table(box=None, pad_edge=False, header_style="bold", title="Maximum path error", title_justify="left")
    rows = [row.texts() for row in comparison.rows()]
    for column, heading in enumerate(HEADINGS):
        # In a narrow terminal headings are wrapped; names and numbers never are.
        width = max((len(texts[column]) for texts in rows), default=1)
        is_name = column < 2
        justify: Literal["left", "right"] = "left" if is_name else "right"
        table.add_column(
            Text(heading), justify=justify, no_wrap=is_name, min_width=0 if is_name else width, overflow="fold"
        )
    method = ""
    for texts in rows:
        table.add_row(*map(Text, (texts[0] if texts[0] != method else "", *texts[1:])))
        method = texts[0]
    return table
