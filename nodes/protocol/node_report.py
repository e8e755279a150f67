"""Report of a node that has ended: exit code, message and figures."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

from flexros.atomic_file import write_whole

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


ERROR_PREFIX = "error: "
"""Prefix of the line that a node prints when it ends with an error."""


@dataclass(frozen=True)
class NodeReport:
    """Result of a node.

    Attributes:
        node: Name of the node.
        exit_code: 0 complete, 2 bad input, 3 aborted.
        message: Error message in one sentence; empty on success.
        figures: Counts and statistics by name.
    """

    node: str
    exit_code: int = 0
    message: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)

    def write(self, path: Path) -> None:
        """Write the report as JSON, atomically."""
        write_whole(path, json.dumps(asdict(self), indent=1) + "\n")


def read_report(path: Path) -> NodeReport | None:
    """Read a report; None if there is none."""
    if not path.is_file():
        return None
    return NodeReport(**json.loads(path.read_text(encoding="utf-8")))
