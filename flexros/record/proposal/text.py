"""A proposed mapping as a YAML file, with its assumptions as comments."""

from __future__ import annotations

import json
from textwrap import wrap
from typing import TYPE_CHECKING

from flexros.logs.foreign.mapping import Clock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.logs.foreign.mapping import LogMapping, MappedColumn
    from flexros.record.proposal.assumption import Assumption

WIDTH = 110


def mapping_text(mapping: LogMapping, assumptions: Sequence[Assumption]) -> str:
    """Return the text of a mapping file.

    Args:
        mapping: The mapping.
        assumptions: What was assumed.
    """
    lines = [f"# {mapping.description}", "# Correct what is wrong, then import the log by this file.", "#"]
    for each in assumptions:
        mark = "" if each.checked else " NOT CHECKED."
        said = f"{each.about}: {each.taken}. {each.ground[:1].upper()}{each.ground[1:]}.{mark}"
        lines += [f"# {line}" for line in wrap(said, WIDTH, subsequent_indent="  ")]
    lines += [f"name: {json.dumps(mapping.name)}", f"description: {json.dumps(mapping.description)}"]
    if isinstance(mapping.time, Clock):
        clock = mapping.time
        column = f"column: {json.dumps(clock.column)}, unit: {clock.unit}"
        lines.append(f"time: {{{column if clock.rate is None else f'rate: {clock.rate}'}}}")
    lines.append("columns:")
    return "\n".join([*lines, *map(_column, mapping.columns)]) + "\n"


def _column(entry: MappedColumn) -> str:
    parts = [f"column: {json.dumps(entry.column)}", f"quantity: {entry.quantity}", f"joint: {entry.joint}"]
    if entry.sign < 0:
        parts.append("sign: -1")
    parts.append(f"unit: {entry.unit}")
    if entry.period is not None:
        parts.append(f"period: {entry.period:.10g}")
    if entry.scale is not None:
        parts.append(f"scale: {{value: {entry.scale.value:g}, unit: {entry.scale.unit}}}")
    return f"  - {{{', '.join(parts)}}}"
