"""Sections of the comparison report: table of methods and cases, their paths and errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.analysis.comparison import HEADINGS
from flexros.analysis.report.error_over_time import tool_errors
from flexros.analysis.report.path import path_picture
from flexros.report.base import AbstractSection, Block, Folded, Paragraph, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.comparison import Comparison, ComparisonRow
    from flexros.analysis.run_analysis import Analysis


_CAPTION = "Maximum path error by method and case, with quoted figures; of several runs of one case the worst is used."


class ComparisonSection(AbstractSection["Sequence[Analysis]"]):
    """Verdict on the methods, table with the quoted figures, and caveats."""

    title: ClassVar[str] = ""

    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return verdict, table and caveats."""
        rows = self._comparison.rows()
        cells: list[tuple[str, ...]] = []
        method = ""
        for row in rows:
            if row.method != method:
                method = row.method
                cells.append((method,))
            cells.append(row.texts()[1:])
        table = TextTable(HEADINGS[1:], tuple(cells), _CAPTION)
        caveats = [Paragraph(text) for text in self._comparison.caveats]
        return (Paragraph(_verdict(rows), "lead"), table, *caveats)


class OverlaySection(AbstractSection["Sequence[Analysis]"]):
    """Paths and errors of all methods over each other, then each method with its own magnification."""

    title: ClassVar[str] = "Paths and errors"

    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the overlay of one run per method, and a picture of all cases of each method."""
        runs = [run for run in self._comparison.runs if run.analysis.path is not None]
        if not runs:
            return ()
        first_case = runs[0].case
        blocks: list[Block] = []
        overlaid = [run.analysis for run in runs if run.case == first_case]
        if len(overlaid) > 1:
            text = f"All methods in the case {first_case}, at one magnification."
            blocks += [Paragraph(text), path_picture(overlaid), tool_errors(overlaid)]
        each = []
        for method in self._comparison.methods:
            cases = [run.analysis for run in runs if run.method == method]
            if cases:
                each.append(path_picture(cases, title=method))
        if len(overlaid) > 1:
            return (*blocks, Folded(f"All cases of each method: {len(each)} pictures", tuple(each)))
        return tuple(each)


def _verdict(rows: Sequence[ComparisonRow]) -> str:
    ranked = sorted((row.attained, row.method, row.case) for row in rows if row.attained is not None)
    if not ranked:
        return "No run has a path error, so there is nothing to compare."
    best, method, case = ranked[0]
    text = f"{method} has the smallest path error, {number(1e3 * best, 3)} mm in the case {case}"
    worst, worst_method, worst_case = ranked[-1]
    if len(ranked) > 1:
        text += f"; {worst_method} the largest, {number(1e3 * worst, 3)} mm in the case {worst_case}"
    near = [row for row in rows if row.deviation is not None and abs(row.deviation) <= 0.1]
    compared = [row for row in rows if row.deviation is not None]
    if compared:
        text += f". {len(near)} of {len(compared)} published figures are met within 10 %"
    return f"{text}."
