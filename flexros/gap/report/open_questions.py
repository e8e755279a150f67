"""Section: limits of the log, and the next experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.words import listed, named
from flexros.report.base import AbstractSection, Block, Listing, Paragraph, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import NextExperiment

_MOVED = 1.0
"""Standard deviations of its tolerance from which a changed parameter is listed (chosen)."""

_NOTHING_TO_RUN = {
    "no_gap": "No further experiment is needed: there is no gap to be explained.",
    "explained": "No further experiment is needed to separate the cause from its rivals.",
    "partly_explained": "No experiment is proposed for the rest, which no known effect explains: the budget shows in "
    "which joint and which motion it is.",
    "ambiguous": "No experiment of the catalogue separates the rivals: measure the tool or the torque as well.",
    "unknown_effect": "No experiment is proposed for a cause that is not among the known effects: the maps of the gap "
    "show which joint and which motion to examine.",
}


class OpenQuestionsSection(AbstractSection["DiagnosisResult"]):
    """Limits of this log, the next experiment, and changes within the tolerance of the model."""

    title: ClassVar[str] = "Limits of this log, and the next experiment"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the limits, the experiment and the tolerances that were used."""
        limits = tuple(Paragraph(text, "against") for text in result.limits)
        experiment = result.diagnosis.next_experiment
        if experiment is None:
            following: tuple[Block, ...] = (Paragraph(_NOTHING_TO_RUN[result.diagnosis.verdict]),)
        else:
            following = _following(experiment)
        return (*limits, *following, *_tolerance(result.tolerance))


def _following(experiment: NextExperiment) -> tuple[Block, ...]:
    rivals = listed([named(location) for location in experiment.separates], "from")
    purpose = f", which separates {rivals}" if rivals else ""
    gain = number(experiment.expected_gain, 3)
    text = (
        f"Run '{experiment.name}' next{purpose}: {experiment.description.rstrip('.')}. Simulated with both "
        f"explanations, it separates the two closest by {gain} nats (3 nats are odds of 20 to 1)."
    )
    command = (Listing(experiment.command, "Command of the experiment."),) if experiment.command else ()
    return (Paragraph(text), *command)


def _tolerance(tolerance: Mapping[str, float]) -> tuple[Block, ...]:
    moved = {name: size for name, size in tolerance.items() if abs(size) >= _MOVED}
    if not moved:
        return ()
    rows = tuple((name, f"{size:+.1f}") for name, size in sorted(moved.items(), key=lambda entry: -abs(entry[1])))
    caption = (
        "Parameters of the nominal model that were changed within its tolerance, in standard deviations of it: they "
        "are not reported as effects."
    )
    return (TextTable(("Parameter", "changed by"), rows, caption),)
