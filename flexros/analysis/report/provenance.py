"""Section: origin of the runs, and limits of the figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Paragraph
from flexros.report.decimate import SCREEN_POINTS
from flexros.report.origin import folded_origin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.analysis.run_analysis import Analysis


class ProvenanceSection(AbstractSection["Sequence[Analysis]"]):
    """Scenario, robot, seed, versions, model hash; warnings; note on pictures."""

    title: ClassVar[str] = "Provenance and limits"

    def blocks(self, analyses: Sequence[Analysis]) -> tuple[Block, ...]:
        """Return the warnings, the table of origins and the note on pictures."""
        blocks: list[Block] = []
        for analysis in analyses:
            blocks += [Paragraph(f"{analysis.label}: {warning}.", "warning") for warning in analysis.warnings]
        origin = folded_origin({analysis.label: analysis.provenance for analysis in analyses}, "run", "runs")
        blocks.append(origin or Paragraph("The logs do not state their origin.", "warning"))
        blocks.append(
            Paragraph(
                f"Pictures draw at most {SCREEN_POINTS} points per curve; longer series are reduced to the smallest "
                "and largest value of equal pieces, which keeps peaks. All figures are computed from every sample.",
                "note",
            )
        )
        return tuple(blocks)
