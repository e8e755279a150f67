"""Section: where the runs came from, and what limits the figures."""

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
    """Scenario, robot, seed, versions, model hash; warnings; how pictures are drawn."""

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
                "and largest value of equal pieces, so that peaks stay. All figures are computed from every sample.",
                "note",
            )
        )
        return tuple(blocks)


def _origin(analyses: Sequence[Analysis]) -> list[Block]:
    """Return what all runs share as one table, and what differs as another with a row per run."""
    runs = [dict(_flat(analysis.provenance)) for analysis in analyses]
    keys = list(dict.fromkeys(key for run in runs for key in run))
    if not keys:
        return [Paragraph("The logs say nothing about where they came from.", "warning")]
    differing = [key for key in keys if len({run.get(key, "-") for run in runs}) > 1]
    common = tuple((key, runs[0][key]) for key in keys if key not in differing)
    tables: list[Block] = []
    if common:
        caption = "Where the run came from." if len(runs) == 1 else "What all runs have in common."
        tables.append(TextTable(("Entry", "Value"), common, caption, left=2))
    if differing:
        rows = tuple(
            (one.label, *(run.get(key, "-") for key in differing)) for one, run in zip(analyses, runs, strict=True)
        )
        header = ("Run", *differing)
        tables.append(TextTable(header, rows, "In what the runs differ.", left=len(header)))
    return tables


def _flat(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a nested mapping as name.key and text."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    else:
        text = ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
        yield name, text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
