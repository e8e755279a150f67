"""Section: origin of the data, and all warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Paragraph, TextTable

if TYPE_CHECKING:
    from flexros.identify.graybox.result import IdentificationResult

_LONGEST = 120
"""Longer texts are cut in the table (chosen)."""


class ProvenanceSection(AbstractSection["IdentificationResult"]):
    """Warnings, scenario, seed, versions."""

    title: ClassVar[str] = "Provenance and limits"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the warnings and the table of origins."""
        blocks: list[Block] = [Paragraph(text, "warning") for text in result.warnings]
        rows = tuple(_flat(result.provenance))
        if rows:
            blocks.append(TextTable(("Entry", "Value"), rows, "Origin of the result.", left=2))
        else:
            blocks.append(Paragraph("The origin of the responses is not known.", "warning"))
        return tuple(blocks)


def _flat(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a nested mapping as name.key and text; what is empty is left out."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    elif value not in (None, "", [], ()):
        text = str(value)
        yield name, text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
