"""The table of the thesis names files that exist, and every control law and observer has its row."""

from __future__ import annotations

import re
from pathlib import Path

from flexros.control.base import control_laws
from flexros.control.observers.base import observers
from flexros.feedforward.base import feedforward_methods

CHECKOUT = Path(__file__).parents[2]
PAGE = (CHECKOUT / "docs" / "reference" / "thesis_map.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("|") and "`" in line]


def test_every_file_of_the_table_exists() -> None:
    named = re.findall(r"`([^`]+/[^`]+)`", PAGE)
    assert len(named) > 80
    assert [name for name in named if not (CHECKOUT / name).is_file()] == []


def test_every_row_has_a_check() -> None:
    for row in ROWS:
        check = row.strip("|").split("|")[3]
        assert re.search(r"`(tests|docs)/", check), row


def test_every_law_observer_and_feedforward_has_a_row() -> None:
    members = [*control_laws().values(), *observers().values(), *map(type, feedforward_methods().values())]
    modules = {member.__module__.replace(".", "/") + ".py" for member in members}
    without = {"flexros/control/observers/differences.py", "flexros/feedforward/none.py"}  # no model, no equation
    assert [name for name in sorted(modules - without) if name not in PAGE] == []
