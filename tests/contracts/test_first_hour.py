"""Journeys of a new user, by the commands of README.md alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.contracts.conftest import folder_of_reader
from tests.program import CHECKOUT, program

hour = program("docs/results/programs/first_hour.py")
JOURNEYS = hour.journeys()


@pytest.mark.guide
@pytest.mark.parametrize("journey", JOURNEYS, ids=lambda journey: journey.name)
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
