"""Texts that hold names from foreign files."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.input_limits import LONGEST_SENTENCE
from flexros.one_line import one_line


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ("topic /a, 5 µs", "topic /a, 5 µs"),
        ("a\nb\tc", "a\\nb\\tc"),
        ("\x1b[2Jgone", "\\x1b[2Jgone"),
        ("name\u202egpj", "name\\u202egpj"),
        ("half a pair \ud83d", "half a pair \\ud83d"),
    ],
)
def test_what_cannot_be_seen_is_spelled_out(given: str, shown: str) -> None:
    assert one_line(given) == shown


@pytest.mark.parametrize("letter", ["x", "\n"])
def test_middle_of_a_long_text_is_omitted(letter: str) -> None:
    shown = one_line(f"begin {letter * 10**6} end")
    assert len(shown) <= LONGEST_SENTENCE
    assert shown.startswith("begin ")
    assert shown.endswith(" end")


def test_error_is_one_line() -> None:
    assert str(InputError("topic '/a\x1b[2J'")) == "topic '/a\\x1b[2J'"
