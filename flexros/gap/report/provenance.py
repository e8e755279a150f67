"""Section: all warnings, where the data came from, and how the answer was made."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Folded, Paragraph, TextTable
from flexros.report.entries import flat_entries, grouped_rows
from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult
    from flexros.record.record import Record


class ProvenanceSection(AbstractSection["DiagnosisResult"]):
    """Warnings; logs; versions, settings and times."""

    title: ClassVar[str] = "Provenance and limits"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return warnings and tables."""
        warnings = dict.fromkeys((*result.diagnosis.warnings, *result.record.warnings))
        blocks: list[Block] = [Paragraph(text, "warning") for text in warnings]
        logs = 1 if result.holdout is None else 2
        blocks.append(Folded(f"The log{'s' * (logs > 1)}: length, rate and sensors", (_logs(result),)))
        defaults = type(result.settings).model_fields
        made = {key: value for key, value in result.diagnosis.provenance.items() if key not in defaults}
        origin = {**result.settings.model_dump(exclude_defaults=True), **made, "time [s]": result.timings}
        entries = dict(flat_entries(origin))
        if entries:
            caption = "How the answer was made. Settings are listed where they differ from their defaults."
            table = TextTable(("Entry", "Value"), grouped_rows(entries), caption, left=2)
            blocks.append(Folded(f"How the answer was made: {len(entries)} settings, versions and times", (table,)))
        return tuple(blocks)


def _logs(result: DiagnosisResult) -> TextTable:
    rows = [_log("fitted to", result.record)]
    if result.holdout is not None:
        rows.append(_log("held out", result.holdout))
    header = ("Use", "log", "length [s]", "rate [Hz]", "missing samples", "input", "tool", "further sensors")
    return TextTable(header, tuple(rows), "The logs.", left=2)


def _log(use: str, record: Record) -> tuple[str, ...]:
    return (
        use,
        record.name,
        number(record.duration, 4),
        number(1 / record.sample_time, 4),
        str(int((~record.valid).sum())),
        record.driven_by,
        "tracked" if record.tool is not None else "not tracked",
        ", ".join(sensor.name for sensor in record.sensors) or "none",
    )
