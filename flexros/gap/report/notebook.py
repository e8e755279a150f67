"""A diagnosis in a notebook: verdict, main figures, ranking, budget."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.report.budget import BudgetSection
from flexros.gap.report.ranking import table_of_ranking
from flexros.gap.report.summary import SummarySection
from flexros.report.notebook import notebook_html

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult
    from flexros.report.base import Block


def diagnosis_html(result: DiagnosisResult) -> str:
    """Show the answer of a diagnosis; `plot` draws its pictures, and the report has the evidence."""
    blocks: list[Block] = [*SummarySection().blocks(result)]
    if result.ranking and result.diagnosis.verdict != "no_gap":
        blocks.append(table_of_ranking(result.ranking))
    blocks += BudgetSection().blocks(result)
    return notebook_html(f"Diagnosis of {result.robot.name}", blocks)
