"""What the pages of campaigns have in common, as lines of Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lay out a table.

    Args:
        headings: Of the columns.
        rows: Cells, one for each column.
    """
    return [f"| {' | '.join(row)} |" for row in (headings, ["---"] * len(headings), *rows)]


def logs_without_answer(failures: Mapping[str, str]) -> list[str]:
    """List the cases that were not diagnosed; nothing where there are none.

    Args:
        failures: What stopped a diagnosis, by name of the case.
    """
    if not failures:
        return []
    lines = (f"- {name}: {text.strip().splitlines()[-1]}" for name, text in failures.items())
    return ["", "## Logs without answer", "", *lines]


def version_line(used: Mapping[str, str]) -> str:
    """Name the versions that computed a page.

    Args:
        used: Versions by package.
    """
    return f"Versions: {', '.join(f'{name} {version}' for name, version in used.items())}"
