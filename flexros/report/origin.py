"""Provenance of what a report is about, folded: what all share once, and the values in which they differ."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.report.base import Block, Folded, TextTable
from flexros.report.entries import differing_rows, flat_entries, grouped_rows

if TYPE_CHECKING:
    from collections.abc import Mapping


def folded_origin(origins: Mapping[str, Mapping[str, object]], one: str, several: str) -> Folded | None:
    """Return, folded, a table of what all origins share and one of the entries in which they differ.

    Args:
        origins: Provenance of each run, diagnosis or the like by its label.
        one: What one of them is, e.g. "run".
        several: The same in plural, e.g. "runs".

    Returns:
        The tables; None where no origin states anything.
    """
    entries = {label: dict(flat_entries(origin)) for label, origin in origins.items()}
    keys = list(dict.fromkeys(key for own in entries.values() for key in own))
    if not keys:
        return None
    first = next(iter(entries.values()))
    common = {key: first[key] for key in keys if len({own.get(key) for own in entries.values()}) == 1}
    tables: list[Block] = []
    differing = differing_rows(entries)
    if differing:
        header = (several[:1].upper() + several[1:], "Value")
        tables.append(TextTable(header, differing, f"Entries in which the {several} differ.", left=2))
    if common:
        caption = f"Origin of the {one}." if len(entries) == 1 else f"Common to all {several}."
        tables.append(TextTable(("Entry", "Value"), grouped_rows(common), caption, left=2))
    what = f"Origin of the {one}" if len(entries) == 1 else f"Origin of the {several}, and in which entries they differ"
    return Folded(f"{what}: {len(keys)} entries", tuple(tables))
