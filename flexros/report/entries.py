"""Nested entries of a provenance as rows of a table, the same in every report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexros.report.number_text import number

LONGEST = 160
"""Longer texts are cut in a table (chosen)."""


def flat_entries(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a nested mapping as name.key and text; what is empty is left out.

    Args:
        value: The mapping, or one value of it.
        name: Name of the value within the outermost mapping.
    """
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from flat_entries(inner, f"{name}.{key}" if name else str(key))
    elif value not in (None, "", [], ()):
        text = number(value, 4) if isinstance(value, float) else _words(value)
        yield name, text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."


def grouped_rows(entries: Mapping[str, str]) -> tuple[tuple[str, ...], ...]:
    """Arrange entries as rows of a table, those of one mapping below its name.

    Args:
        entries: Texts by name, as from `flat_entries`.

    Returns:
        Rows of name and text; a row of one cell is the name of the mapping that the rows below it belong to.
    """
    rows: list[tuple[str, ...]] = [(key, text) for key, text in entries.items() if "." not in key]
    inner: dict[str, list[tuple[str, ...]]] = {}
    for key, text in entries.items():
        group, dot, rest = key.partition(".")
        if dot:
            inner.setdefault(group, []).append((rest, text))
    for group, below in inner.items():
        rows += [(group,), *below]
    return tuple(rows)


def differing_rows(runs: Mapping[str, Mapping[str, str]]) -> tuple[tuple[str, ...], ...]:
    """List the entries in which runs differ, one row for each value with the runs that have it.

    Args:
        runs: Entries of each run by its label.

    Returns:
        Rows of labels and value; the name of the entry stands above its values.
    """
    rows: list[tuple[str, ...]] = []
    for key in dict.fromkeys(key for entries in runs.values() for key in entries):
        labels: dict[str, list[str]] = {}
        for label, entries in runs.items():
            labels.setdefault(entries.get(key, "-"), []).append(label)
        if len(labels) > 1:
            most = max(labels.values(), key=len)
            named = {
                value: f"the other {len(having)}" if having is most and len(having) > 2 else ", ".join(having)
                for value, having in labels.items()
            }
            rows += [(key,), *((who, value) for value, who in named.items())]
    return tuple(rows)


def _words(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
