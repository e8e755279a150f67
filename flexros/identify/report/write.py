"""The report of an identification: one HTML page that opens offline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.report.distortion_levels import DistortionSection
from flexros.identify.report.experiment import ExperimentSection
from flexros.identify.report.multistart import StartSection
from flexros.identify.report.parameters import ParameterSection
from flexros.identify.report.provenance import ProvenanceSection
from flexros.identify.report.residuals import ResidualSection
from flexros.identify.report.responses import ResponseSection
from flexros.identify.report.summary import SummarySection
from flexros.identify.report.undetermined import UndeterminedSection
from flexros.report.page import Chapter, page_html

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult
    from flexros.report.base import AbstractSection

SECTIONS: tuple[AbstractSection[IdentificationResult], ...] = (
    SummarySection(),
    ParameterSection(),
    UndeterminedSection(),
    ResponseSection(),
    ResidualSection(),
    DistortionSection(),
    ExperimentSection(),
    StartSection(),
    ProvenanceSection(),
)
"""Sections in order of appearance."""


def identification_report(result: IdentificationResult, *, title: str | None = None) -> str:
    """Make the report of an identification.

    Args:
        result: The identification.
        title: Heading; None for the name of the robot.

    Returns:
        The HTML page.
    """
    chapters = [Chapter(section.title, section.blocks(result)) for section in SECTIONS]
    heading = title or f"Identification of {result.problem.robot.name}"
    return page_html(heading, _subtitle(result), chapters)


def _subtitle(result: IdentificationResult) -> str:
    positions = len(result.problem.responses)
    count = len(result.fit.names)
    text = f"{count} parameter{'s' * (count > 1)}, {positions} position{'s' * (positions > 1)}"
    return f"{text}, estimator {result.fit.estimator} with {result.fit.weights} weights"
