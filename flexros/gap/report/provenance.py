"""Section: all warnings, where the data came from, and how the answer was made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, ClassVar

from flexros.report.base import AbstractSection, Block, Paragraph, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult
    from flexros.record.record import Record

_LONGEST = 160
"""Longer texts are cut in the table (chosen)."""


class ProvenanceSection(AbstractSection["DiagnosisResult"]):
    """Warnings; logs; versions, settings and times."""

    title: ClassVar[str] = "Provenance and limits"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return warnings and tables."""
        warnings = dict.fromkeys((*result.diagnosis.warnings, *result.record.warnings))
        blocks: list[Block] = [Paragraph(text, "warning") for text in warnings]
        blocks.append(_logs(result))
        defaults = type(result.settings).model_fields
        made = {key: value for key, value in result.diagnosis.provenance.items() if key not in defaults}
        origin = {**result.settings.model_dump(exclude_defaults=True), **made, "time [s]": result.timings}
        rows = tuple(_flat(origin))
        if rows:
            blocks.append(
                TextTable(
                    ("Entry", "Value"),
                    rows,
                    "How the answer was made. Settings are listed where they differ from their defaults.",
                    left=2,
                )
            )
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


def _flat(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a nested mapping as name.key and text; what is empty is left out."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    elif value not in (None, "", [], ()):
        text = f"{value:.4g}" if isinstance(value, float) else str(value)
        yield name, text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
