"""Journeys of a new user, by the commands of README.md alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.contracts.conftest import folder_of_reader, marked_blocks
from tests.contracts.test_guide import DOCS, MARKER
from tests.program import CHECKOUT, program

hour = program("docs/results/programs/first_hour.py")
JOURNEYS = hour.journeys()
ON_THEIR_PAGE = ("A repaired model of a UR5e from a bag",)
"""Journeys whose commands stand on their page too, which test_guide.py runs: a diagnosis is not run twice."""


def commands_of(block: str) -> list[str]:
    """Give the commands of a block without what is said about them."""
    lines = (line.partition("  #")[0].rstrip() for line in block.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


@pytest.mark.parametrize("name", ON_THEIR_PAGE)
def test_commands_of_the_readme_stand_on_the_page_in_the_same_order(name: str) -> None:
    (journey,) = (one for one in JOURNEYS if one.name == name)
    blocks = marked_blocks((DOCS / hour.PAGES[name]).read_text(encoding="utf-8"), MARKER)
    run = [command for block in blocks for command in commands_of(block)]
    install, *wanted = commands_of(journey.commands)
    assert install == "pip install --quiet mujoco", "what the extra `test` has installed"
    assert len(wanted) > 5
    assert [command for command in run if command in wanted] == wanted


@pytest.mark.guide
@pytest.mark.parametrize(
    "journey", [one for one in JOURNEYS if one.name not in ON_THEIR_PAGE], ids=lambda journey: journey.name
)
def test_commands_of_the_readme_run(journey: hour.Journey, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    if journey.over_topics:
        request.getfixturevalue("ros_domain")
    folder, variables = folder_of_reader(tmp_path)
    journey.run(folder, variables)


def test_readme_and_page_have_all_journeys_and_the_same_times() -> None:
    page = (CHECKOUT / "docs/results/first_hour.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| ([^|]*) \| \[page\]\([^)]*\) \| (\d+) \|", page, re.MULTILINE))
    assert {journey.name: str(journey.seconds) for journey in JOURNEYS} == rows
    assert list(rows) == list(hour.PAGES)
    assert max(map(int, rows.values())) < 600, "ten minutes each"


@pytest.mark.parametrize("page", hour.PAGES.values())
def test_page_exists(page: str) -> None:
    assert (CHECKOUT / "docs" / page).is_file()
