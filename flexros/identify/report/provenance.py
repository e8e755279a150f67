"""Section: origin of the data, and all warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Folded, Paragraph, TextTable
from flexros.report.entries import flat_entries, grouped_rows

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult


class ProvenanceSection(AbstractSection["IdentificationResult"]):
    """Warnings, scenario, seed, versions."""

    title: ClassVar[str] = "Provenance and limits"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the warnings and the table of origins."""
        blocks: list[Block] = [Paragraph(text, "warning") for text in result.warnings]
        entries = dict(flat_entries(result.provenance))
        if entries:
            table = TextTable(("Entry", "Value"), grouped_rows(entries), "Origin of the result.", left=2)
            blocks.append(Folded(f"Origin of the result: {len(entries)} entries", (table,)))
        else:
            blocks.append(Paragraph("The origin of the responses is not known.", "warning"))
        return tuple(blocks)
