"""Result of a part of the endurance test."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

OK = "ok"


@dataclass
class Result:
    """Rows of a table; the last column says "ok", or what went wrong.

    Attributes:
        columns: Headings, without the last.
        rows: Texts, each row with its verdict.
        notes: Sentences with further figures.
    """

    columns: list[str]
    rows: list[list[str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(self, *texts: str, wrong: str = "") -> None:
        """Add a row; `wrong` says what is not as it must be."""
        self.rows.append([*texts, wrong or OK])

    @property
    def survived(self) -> int:
        return sum(row[-1] == OK for row in self.rows)

    @property
    def wrong(self) -> list[str]:
        return [" | ".join(row) for row in self.rows if row[-1] != OK]

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def table(self) -> str:
        """Write the table in Markdown."""
        heads = [*self.columns, "verdict"]
        lines = [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}"]
        return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in self.rows)])


def differing(what: str, found: list[str]) -> str:
    """Return how logs differ, empty if they do not."""
    return f"{what} differs in {', '.join(found)}" if found else ""
