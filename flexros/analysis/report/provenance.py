"""Section: origin of the runs, and limits of the figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Paragraph, TextTable
from flexros.report.decimate import SCREEN_POINTS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.analysis.run_analysis import Analysis

_LONGEST = 300
"""Longer texts are cut in the table."""


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


def _origin(analyses: Sequence[Analysis]) -> list[Block]:
    """Return a table of what all runs share, and one of the differences with a row per run."""
    runs = [dict(_flat(analysis.provenance)) for analysis in analyses]
    keys = list(dict.fromkeys(key for run in runs for key in run))
    if not keys:
        return [Paragraph("The logs do not state their origin.", "warning")]
    differing = [key for key in keys if len({run.get(key, "-") for run in runs}) > 1]
    common = tuple((key, runs[0][key]) for key in keys if key not in differing)
    tables: list[Block] = []
    if common:
        caption = "Origin of the run." if len(runs) == 1 else "Common to all runs."
        tables.append(TextTable(("Entry", "Value"), common, caption, left=2))
    if differing:
        rows = tuple(
            (analysis.label, *(run.get(key, "-") for key in differing))
            for analysis, run in zip(analyses, runs, strict=True)
        )
        header = ("Run", *differing)
        tables.append(TextTable(header, rows, "Differences between the runs.", left=len(header)))
    return tables


def _flat(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a nested mapping as name.key and text."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    else:
        text = ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
        yield name, text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
