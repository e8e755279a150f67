"""Write a report of one or several runs: one HTML file that opens offline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.analysis.report.comparison import ComparisonSection, OverlaySection
from flexros.analysis.report.error_over_time import ErrorSection
from flexros.analysis.report.figures import FiguresSection
from flexros.analysis.report.frequency_responses import FrequencyResponseSection
from flexros.analysis.report.path import PathSection
from flexros.analysis.report.provenance import ProvenanceSection
from flexros.analysis.report.summary import SummarySection
from flexros.analysis.report.timing import TimingSection
from flexros.analysis.report.torques import TorqueSection
from flexros.atomic_file import write_result
from flexros.errors import InputError
from flexros.report.page import Chapter, page_html

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.analysis.comparison import Comparison
    from flexros.analysis.run_analysis import Analysis
    from flexros.report.base import AbstractSection

RUN_SECTIONS: tuple[AbstractSection[Sequence[Analysis]], ...] = (
    SummarySection(),
    PathSection(),
    ErrorSection(),
    FrequencyResponseSection(),
    TorqueSection(),
    TimingSection(),
    FiguresSection(),
    ProvenanceSection(),
)
"""Sections of the report of runs, in order of appearance."""


_AFTER_PATH = 2
"""Place of further chapters: behind summary and path."""


def write_report(
    analyses: Sequence[Analysis], file: Path, *, title: str | None = None, further: Sequence[Chapter] = ()
) -> None:
    """Write the report of one run, or of several side by side.

    Args:
        analyses: The runs, at least analysis.
        file: The HTML file; an existing one is replaced once the new one is complete.
        title: Heading; None for the label of the run, or the number of runs.
        further: Chapters that follow the path, e.g. of the arm in motion.

    Raises:
        InputError: No run was given, or the file cannot be written.
    """
    if not analyses:
        raise InputError("no run was given for the report: give at least one log")
    chapters = [Chapter(section.title, section.blocks(analyses)) for section in RUN_SECTIONS]
    chapters[_AFTER_PATH:_AFTER_PATH] = further
    heading = title or (analyses[0].label if len(analyses) == 1 else f"Comparison of {len(analyses)} runs")
    write_result(file, page_html(heading, _subtitle(analyses), chapters), "report")


def write_comparison(comparison: Comparison, file: Path, *, title: str = "Comparison of methods") -> None:
    """Write the report of methods and cases compared with quoted figures.

    Args:
        comparison: The runs by method and case, and the quoted figures.
        file: The HTML file; an existing one is replaced once the new one is complete.
        title: Heading.

    Raises:
        InputError: There is no run, or the file cannot be written.
    """
    if not comparison.runs:
        raise InputError("no run was given for the comparison: give at least one method and case")
    analyses = [run.analysis for run in comparison.runs]
    first_case = [run.analysis for run in comparison.runs if run.case == comparison.runs[0].case]
    torques = TorqueSection()
    chapters = [
        Chapter(ComparisonSection.title, ComparisonSection(comparison).blocks(analyses)),
        Chapter(OverlaySection.title, OverlaySection(comparison).blocks(analyses)),
        Chapter(torques.title, torques.blocks(first_case)),
        *(
            Chapter(section.title, section.blocks(analyses))
            for section in (TimingSection(), FiguresSection(), ProvenanceSection())
        ),
    ]
    write_result(file, page_html(title, _subtitle(analyses), chapters), "report")


def _subtitle(analyses: Sequence[Analysis]) -> str:
    longest = max(analysis.duration for analysis in analyses)
    samples = sum(
        topic.count for analysis in analyses for topic in analysis.timing.topics if topic.topic == "joint_states"
    )
    runs = "One run" if len(analyses) == 1 else f"{len(analyses)} runs"
    return f"{runs}, {'' if len(analyses) == 1 else 'up to '}{longest:.4g} s, {samples} samples"
