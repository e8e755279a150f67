"""Layout: tests mirror the package, and the number of files in a folder is limited."""

from __future__ import annotations

from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
ROOMS = sorted(path.name for path in (CHECKOUT / "flexros").iterdir() if any(path.glob("[!_]*.py")))
NOT_ROOMS = {"contracts", "golden", "bench", "oracles", "fuzz", "soak", "nodes", "validation"}
"""Folders of tests in addition to rooms: contracts, stored results, benchmarks, oracles, damaged input."""
MOST_FILES = 30
"""Modules in one folder; `flexros/effects` has one file per effect."""


@pytest.mark.parametrize("room", [*ROOMS, "nodes", "validation"])
def test_room_has_tests(room: str) -> None:
    assert list((CHECKOUT / "tests" / room).rglob("test_*.py"))


def test_no_tests_without_a_room() -> None:
    folders = {path.name for path in (CHECKOUT / "tests").iterdir() if any(path.glob("*.py"))}
    assert folders <= {*ROOMS, *NOT_ROOMS}


def test_no_folder_is_too_full() -> None:
    folders = [path for top in ("flexros", "nodes", "tests") for path in (CHECKOUT / top).rglob("*") if path.is_dir()]
    counts = {str(path.relative_to(CHECKOUT)): len(list(path.glob("*.py"))) for path in folders}
    assert [folder for folder, count in counts.items() if count > MOST_FILES] == []
