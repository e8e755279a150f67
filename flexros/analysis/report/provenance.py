"""Section: origin of the runs, and limits of the figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Folded, Paragraph, TextTable
from flexros.report.decimate import SCREEN_POINTS
from flexros.report.entries import differing_rows, flat_entries, grouped_rows

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
        blocks += _origin(analyses)
        blocks.append(
            Paragraph(
                f"Pictures draw at most {SCREEN_POINTS} points per curve; longer series are reduced to the smallest "
                "and largest value of equal pieces, which keeps peaks. All figures are computed from every sample.",
                "note",
            )
        )
        return tuple(blocks)


def _origin(analyses: Sequence[Analysis]) -> tuple[Block, ...]:
    """Return, folded, a table of what all runs share and one of the values in which they differ."""
    runs = {analysis.label: dict(flat_entries(analysis.provenance)) for analysis in analyses}
    keys = list(dict.fromkeys(key for entries in runs.values() for key in entries))
    if not keys:
        return (Paragraph("The logs do not state their origin.", "warning"),)
    first = next(iter(runs.values()))
    common = {key: first[key] for key in keys if len({entries.get(key) for entries in runs.values()}) == 1}
    tables: list[Block] = []
    if common:
        caption = "Origin of the run." if len(runs) == 1 else "Common to all runs."
        tables.append(TextTable(("Entry", "Value"), grouped_rows(common), caption, left=2))
    differing = differing_rows(runs)
    if differing:
        tables.insert(0, TextTable(("Value", "Runs"), differing, "Entries in which the runs differ.", left=2))
    what = "Origin of the run" if len(runs) == 1 else "Origin of the runs, and in which entries they differ"
    return (Folded(f"{what}: {len(keys)} entries", tuple(tables)),)
