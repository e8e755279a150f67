"""The journeys that docs/results/first_hour.py times: pages, commands and tests are there."""

from __future__ import annotations

import re

import pytest

from tests.program import CHECKOUT, program

pytest.importorskip("rclpy", reason="the program claims a ROS domain")
hour = program("docs/results/first_hour.py")


def test_there_are_four_and_the_page_has_their_times() -> None:
    page = (CHECKOUT / "docs/results/first_hour.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| ([^|]*) \| \[page\]\([^)]*\) \| (\d+) \|", page, re.MULTILINE))
    assert list(rows) == [journey.name for journey in hour.JOURNEYS]
    assert len(rows) == 4
    assert max(map(int, rows.values())) < 600, "ten minutes each"


@pytest.mark.parametrize("journey", hour.JOURNEYS, ids=lambda journey: journey.name)
def test_page_and_test_exist(journey: hour.Journey) -> None:
    assert (CHECKOUT / "docs" / journey.page).is_file()
    file, _, name = journey.test.partition("::")
    assert f"def {name}(" in (CHECKOUT / file).read_text(encoding="utf-8")


def test_commands_of_the_journeys_are_on_their_pages() -> None:
    assert any("six_axis" in one for one in hour.blocks_of("how-to/own_controller.md", f"{hour.MARKER} with ROS 2"))
    assert any("repaired.urdf" in one for one in hour.blocks_of("tutorials/ur5e.md", hour.MARKER))
