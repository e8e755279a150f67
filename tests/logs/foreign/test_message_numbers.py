"""Numbers of a message by name."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexros.input_limits import MOST_ENTRIES
from flexros.logs.foreign.message_numbers import message_numbers


@dataclass
class Inner:
    positions: Any
    on: bool = True


@dataclass
class Outer:
    joint_names: list[str]
    inner: Inner
    list_of: list[Inner] = field(default_factory=list)
    header: Any = None
    text: str = "left out"


def test_lists_below_the_names_go_by_them_where_the_lengths_agree() -> None:
    found = message_numbers(Outer(["a", "b"], Inner(np.array([1.0, 2.0])), [Inner([3]), Inner([])]))
    assert found == {
        "inner.positions[a]": 1.0,
        "inner.positions[b]": 2.0,
        "inner.on": 1.0,
        "list_of[a].positions[0]": 3.0,
        "list_of[a].on": 1.0,
        "list_of[b].on": 1.0,
    }


def test_names_that_stand_twice_name_nothing() -> None:
    assert list(message_numbers(Outer(["a", "a"], Inner([1, 2])))) == [
        "inner.positions[0]",
        "inner.positions[1]",
        "inner.on",
    ]


def test_longest_list() -> None:
    assert len(message_numbers(Outer([], Inner(np.zeros(MOST_ENTRIES))))) == MOST_ENTRIES + 1
    assert list(message_numbers(Outer([], Inner(np.zeros(MOST_ENTRIES + 1))))) == ["inner.on"]
