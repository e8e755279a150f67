"""Write the report of a diagnosis: one HTML file that opens offline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.atomic_file import write_result
from flexros.gap.report.budget import BudgetSection
from flexros.gap.report.evidence import EvidenceSection
from flexros.gap.report.how_far import HowFarSection
from flexros.gap.report.open_questions import OpenQuestionsSection
from flexros.gap.report.patch import PatchSection
from flexros.gap.report.provenance import ProvenanceSection
from flexros.gap.report.ranking import RankingSection
from flexros.gap.report.summary import SummarySection
from flexros.gap.report.where import WhereSection
from flexros.report.number_text import number
from flexros.report.page import Chapter, page_html

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.gap.result import DiagnosisResult
    from flexros.report.base import AbstractSection


def sections(patch: str = "") -> tuple[AbstractSection[DiagnosisResult], ...]:
    """List the sections in order of appearance.

    Args:
        patch: Text of patch.yaml; empty where no effect was found.
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
        patch: Text of patch.yaml; empty where no effect was found.
        title: Heading; None for robot and log.
    """
    every = [Chapter(section.title, section.blocks(result)) for section in sections(patch)]
    chapters = [chapter for chapter in every if chapter.blocks]
    return page_html(title or f"Diagnosis of {result.robot.name}", _subtitle(result), chapters, packed=True)


def write_diagnosis_report(result: DiagnosisResult, file: Path, *, patch: str = "", title: str | None = None) -> None:
    """Write the report of a diagnosis.

    Args:
        result: The diagnosis.
        file: The HTML file; one that exists is replaced once the new one is complete.
        patch: Text of patch.yaml; empty where no effect was found.
        title: Heading; None for robot and log.

    Raises:
        InputError: The file cannot be written.
    """
    write_result(file, diagnosis_report(result, patch=patch, title=title), "report")


def _subtitle(result: DiagnosisResult) -> str:
    record = result.record
    fitted = f"log {record.name}, {number(record.duration, 3)} s at {number(1 / record.sample_time, 4)} Hz"
    held = ""
    if result.holdout is not None:
        rest = f"the last {number(result.holdout.duration, 3)} s of it"
        held = f", checked on {rest if result.holdout.name == result.record.name else result.holdout.name}"
    motors = record.position.shape[1]
    return f"{fitted}, {motors} motor{'s' * (motors > 1)}{held}"
