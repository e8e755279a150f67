"""Limits of the readers, and the page of the guide that lists them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexros import input_limits
from flexros.input_limits import EXPANSION, EXPANSION_ALLOWANCE, room_of

PAGE = (Path(__file__).parents[1] / "docs" / "reference" / "limits.md").read_text(encoding="utf-8")
LIMITS = {name: value for name, value in vars(input_limits).items() if name.isupper()}


@pytest.mark.parametrize("name", LIMITS)
def test_guide_tells_the_limit(name: str) -> None:
    (told,) = re.findall(rf"^\| `{name}` \| ([\d ]+?)(?: byte| characters)? \|", PAGE, re.MULTILINE)
    assert int(told.replace(" ", "")) == LIMITS[name]


def test_guide_lists_no_other_limit() -> None:
    assert set(re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE)) == set(LIMITS)


def test_room_grows_with_the_file() -> None:
    assert room_of(0) == EXPANSION_ALLOWANCE
    assert room_of(1000) == EXPANSION_ALLOWANCE + 1000 * EXPANSION
