"""Tables of parameters for the terminal: names and numbers never wrap, columns that do not fit are dropped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.table import Table

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult

_FRAME, _PADDED = 1, 3
"""Characters of the frame of a table, and of the frame and the padding of each column."""


def parameter_table(result: IdentificationResult, width: int) -> Table:
    """Lay out the identified parameters.

    Args:
        result: The identification.
        width: Width of the terminal [characters].

    Returns:
        The table: name with unit, nominal and fitted value, 95 % interval in per cent, verdict, and the true value
        where it is known. The true and the nominal value are left out where the table would be too wide with them; all
        figures are in the report.
    """
    return fitting_table(_columns(result), width, ("true", "nominal"), broken="verdict")


def fitting_table(columns: dict[str, list[str]], width: int, dropped: tuple[str, ...], broken: str = "") -> Table:
    """Lay out columns without wrapping their entries.

    Args:
        columns: Texts by label, of equal number; the first column is left-aligned.
        width: Width of the terminal [characters].
        dropped: Columns that are dropped where the table is too wide, first to last.
        broken: Column that may wrap between words.

    Returns:
        The table.
    """
    shown = dict(columns)
    for label in dropped:
        if _wide(shown, broken) > width:
            shown.pop(label, None)
    table = Table()
    for column, label in enumerate(shown):
        table.add_column(label, no_wrap=label != broken, justify="right" if column else "left")
    for row in zip(*shown.values(), strict=True):
        table.add_row(*row)
    return table


def _columns(result: IdentificationResult) -> dict[str, list[str]]:
    from flexros.identify.report.words import VERDICT_WORDS, reach_text, rounded_text, true_text, value_text

    entries = result.identifiability.parameters
    columns = {
        "parameter": [f"{entry.name} [{entry.unit}]" if entry.unit else entry.name for entry in entries],
        "nominal": [value_text(float(value)) for value in result.nominal],
        "fitted": [rounded_text(entry.value, *entry.interval) for entry in entries],
        "± 95 %": [reach_text(entry.interval[0], entry.value, entry.interval[1]) for entry in entries],
        "verdict": [VERDICT_WORDS[entry.verdict] for entry in entries],
    }
    if result.truth:
        truth = [result.truth.get(entry.name) for entry in entries]
        columns["true"] = [
            "-" if true is None else true_text(true, *entry.interval)
            for true, entry in zip(truth, entries, strict=True)
        ]
    return columns


def _wide(columns: dict[str, list[str]], broken: str) -> int:
    """Width of the table, with one column as narrow as its longest word."""
    words = (
        [word for text in (label, *texts) for word in (text.split() if label == broken else [text])]
        for label, texts in columns.items()
    )
    return _FRAME + sum(_PADDED + max(map(len, each)) for each in words)
