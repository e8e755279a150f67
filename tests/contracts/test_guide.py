"""Commands of the guide, run as printed."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
FOLDERS = ("tutorials", "how-to", "reference", "explanation")
MARKER = "run by tests/contracts/test_guide.py"
MARKER_WITH_ROS = f"{MARKER} with ROS 2"
PAGES = {
    path.name: path.read_text(encoding="utf-8") for folder in FOLDERS for path in sorted((DOCS / folder).glob("*.md"))
}

Run = Callable[[str, str], int]


def pages_with(marker: str) -> list[str]:
    return [name for name, text in PAGES.items() if f"<!-- {marker} -->" in text]


@pytest.mark.guide
@pytest.mark.parametrize("page", pages_with(MARKER))
def test_marked_commands_run(page: str, run_marked: Run) -> None:
    assert run_marked(PAGES[page], MARKER)


@pytest.mark.guide
@pytest.mark.usefixtures("ros_domain")
@pytest.mark.parametrize("page", pages_with(MARKER_WITH_ROS))
def test_marked_commands_run_with_ros(page: str, run_marked: Run) -> None:
    assert run_marked(PAGES[page], MARKER_WITH_ROS)


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_run_or_the_page_says_why_not(page: str) -> None:
    """Blocks without a language are commands: each stands below a mark."""
    known = {MARKER, MARKER_WITH_ROS}
    text = PAGES[page]
    for line in re.findall(r"<!-- (.*?) -->", text):
        assert line in known or line.startswith(("not run: ", "written by ")), f"<!-- {line} -->"
    for before, language, first in re.findall(r"^(.*)\n```(\w*)\n(.*)\n(?:.*\n)*?```$", text, re.MULTILINE):
        assert language or before.startswith("<!-- "), f"not marked: {first}"
