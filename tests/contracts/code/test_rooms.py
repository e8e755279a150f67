"""Layout: tests mirror the package, and the number of files in a folder is limited."""

from __future__ import annotations

from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]
ROOMS = sorted(path.name for path in (CHECKOUT / "flexros").iterdir() if any(path.glob("[!_]*.py")))
NOT_ROOMS = {"contracts", "golden", "bench", "oracles", "fuzz", "soak", "nodes", "validation", "results"}
"""Folders of tests in addition to rooms: contracts, stored results, benchmarks, oracles, damaged input, and programs of
pages of results."""
MOST_FILES = 21
"""Files in one folder: about 20, and `__init__.py`."""
LISTS = {
    "flexros/effects",  # one file per effect
    "tests/effects",
    "flexros/record/checks",  # one file per check of a record
    "tests/record/checks",
    "flexros/scenario/library",  # one file per built-in scenario
    "docs/how-to",  # one page per task
    "docs/results",  # one page per question
    "docs/results/data/real_robots",  # one file per measured robot
    "docs/results/programs/measured",  # a mapping and a robot file per measured robot
    "docs/reference/api",  # one page per room
    "docs/reference/json",  # generated: a schema per command
    "docs/reference/python",  # generated: a page per function or class
    "docs/reference/pictures/effects",  # generated: a picture per effect
}
"""Folders that list the members of one registry or navigation, where a reader looks for a name."""


@pytest.mark.parametrize("room", [*ROOMS, "nodes", "validation"])
def test_room_has_tests(room: str) -> None:
    assert list((CHECKOUT / "tests" / room).rglob("test_*.py"))


def test_no_tests_without_a_room() -> None:
    folders = {path.name for path in (CHECKOUT / "tests").iterdir() if any(path.glob("*.py"))}
    assert folders <= {*ROOMS, *NOT_ROOMS}


def test_no_folder_is_too_full() -> None:
    tops = (CHECKOUT / top for top in ("flexros", "nodes", "tests", "docs"))
    folders = [path for top in tops for path in top.rglob("*") if path.is_dir() and path.name != "__pycache__"]
    counts = {str(path.relative_to(CHECKOUT)): sum(file.is_file() for file in path.iterdir()) for path in folders}
    full = {folder for folder, count in counts.items() if count > MOST_FILES}
    assert full - LISTS == set()
    assert set(counts) >= LISTS
