"""The report of a diagnosis: one HTML file that opens offline, and its short form for a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.budget import BudgetSection
from flexros.gap.report.evidence import EvidenceSection
from flexros.gap.report.how_far import HowFarSection
from flexros.gap.report.open_questions import OpenQuestionsSection
from flexros.gap.report.provenance import ProvenanceSection
from flexros.gap.report.ranking import RankingSection, table_of_ranking
from flexros.gap.report.summary import SummarySection
from flexros.gap.report.where import WhereSection
from flexros.report.base import AbstractSection, Block, Listing, Paragraph
from flexros.report.notebook import notebook_html
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult

_USELESS = 0.1
"""A patch that closes less of the gap than this share is not recommended (chosen)."""


class PatchSection(AbstractSection["DiagnosisResult"]):
    """The text of patch.yaml and the commands that use it."""

    title: ClassVar[str] = "The patch"

    def __init__(self, text: str) -> None:
        """Take the patch as YAML, empty where there is nothing to repair."""
        self._text = text

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the patch with its commands."""
        if not self._text:
            return ()
        text = (
            "The effects with their fitted parameters on top of the nominal robot. The file patch.yaml is accepted "
            "wherever a robot is: for simulation, feedforward or another diagnosis."
        )
        if result.diagnosis.verdict == "no_gap":
            text += " It states what the robot file leaves out; with it there is no gap."
        if result.diagnosis.verdict == "unknown_effect":
            text += " It repairs only a part of the gap, whose cause is not among the known effects."
        if result.diagnosis.verdict == "partly_explained":
            text += " It repairs a part of the gap; the budget says how much is left, and where."
        if result.diagnosis.verdict == "ambiguous":
            text += (
                " It holds the most probable explanation, which predicts motions like those of this log as well as its "
            )
            text += "rivals."
        closed = result.diagnosis.gap.closed_fraction
        if closed is not None and closed < _USELESS:
            text = "The effects with their fitted parameters. Do not use them: they do not reduce the held-out gap."
        commands = "flexros gap BAG --model patch.yaml      # a new log against the repaired model\n"
        commands += "flexros run SCENARIO --model patch.yaml  # simulate, with a feedforward that knows the effects\n"
        return (
            Paragraph(text),
            Listing(self._text, "patch.yaml, in the folder of this report."),
            Listing(commands, "Commands that use it."),
        )


def sections(patch: str = "") -> tuple[AbstractSection[DiagnosisResult], ...]:
    """List the sections in order of appearance.

    Args:
        patch: Text of patch.yaml; empty where there is nothing to repair.
    """
    return (
        SummarySection(),
        BudgetSection(),
        WhereSection(),
        RankingSection(),
        EvidenceSection(),
        HowFarSection(),
        OpenQuestionsSection(),
        PatchSection(patch),
        ProvenanceSection(),
    )


def diagnosis_report(result: DiagnosisResult, *, patch: str = "", title: str | None = None) -> str:
    """Return the report of a diagnosis as an HTML page.

    Args:
        result: The diagnosis.
        patch: Text of patch.yaml; empty where there is nothing to repair.
        title: Heading; None for robot and log.
    """
    every = [Chapter(section.title, section.blocks(result)) for section in sections(patch)]
    chapters = [chapter for chapter in every if chapter.blocks]
    return page_html(title or f"Diagnosis of {result.robot.name}", _subtitle(result), chapters, packed=True)


def diagnosis_html(result: DiagnosisResult) -> str:
    """Show the answer of a diagnosis; `plot` draws its pictures, and the report has the evidence."""
    blocks: list[Block] = [*SummarySection().blocks(result)]
    if result.ranking and result.diagnosis.verdict != "no_gap":
        blocks.append(table_of_ranking(result))
    blocks += BudgetSection().blocks(result)
    return notebook_html(f"Diagnosis of {result.robot.name}", blocks)


def _subtitle(result: DiagnosisResult) -> str:
    record = result.record
    fitted = f"log {record.name}, {number(record.duration, 3)} s at {number(1 / record.sample_time, 4)} Hz"
    held = ""
    if result.holdout is not None:
        rest = f"the last {number(result.holdout.duration, 3)} s of it"
        held = f", checked on {rest if result.holdout.name == result.record.name else result.holdout.name}"
    motors = record.position.shape[1]
    return f"{fitted}, {motors} motor{'s' * (motors > 1)}{held}"
