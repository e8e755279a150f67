"""What every command has, also a new one: purpose, example, options with units, JSON, next step and progress."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from typing import Any

import pytest
import typer

from flexros.cli.app import app
from flexros.cli.guide import GUIDES

NO_FIGURES = {
    "view": "shows a page until Ctrl-C",
    "blind make": "writes sealed cases for blind run",
    "blind run": "writes answers for blind score",
}
"""Commands that print no figures, and why."""
AT_ONCE = {"robots": "a list of files", "scenarios": "a list of files"}
"""Commands that never take two seconds, and why."""
PROGRESS = ("progress_bar(", "progress_shown(", "working(")


def leaves(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    if hasattr(command, "commands"):
        for word, part in command.commands.items():
            yield from leaves(part, (*words, word))
    else:
        yield " ".join(words), command


COMMANDS = dict(leaves(typer.main.get_command(app)))


def function(command: Any) -> Any:
    return inspect.unwrap(command.callback)


@pytest.mark.parametrize("name", COMMANDS)
def test_purpose_is_one_short_line_and_there_is_an_example(name: str) -> None:
    guide = GUIDES[name]
    assert 0 < len(guide.short) <= 62
    assert "\n" not in guide.short
    assert guide.examples


@pytest.mark.parametrize("name", COMMANDS)
def test_options_are_described_and_quantities_have_units(name: str) -> None:
    kinds = inspect.signature(function(COMMANDS[name])).parameters
    for option in COMMANDS[name].params:
        if option.name not in kinds:
            continue
        described = option.help or ""
        assert described.endswith((".", "]")), f"{option.opts[-1]}: {described!r}"
        assert "float" not in str(kinds[option.name].annotation) or "[" in described, f"{option.opts[-1]} has no unit"


@pytest.mark.parametrize("name", COMMANDS)
def test_figures_are_also_printed_as_json(name: str) -> None:
    assert any("--json" in option.opts for option in COMMANDS[name].params) != (name in NO_FIGURES)


@pytest.mark.parametrize("name", COMMANDS)
def test_work_shows_its_progress(name: str) -> None:
    source = inspect.getsource(function(COMMANDS[name]))
    module = inspect.getsource(sys.modules[function(COMMANDS[name]).__module__])
    assert any(word in module for word in PROGRESS) or name in AT_ONCE, source


@pytest.mark.parametrize("name", sorted({*COMMANDS} - {"view"}))  # it ends with Ctrl-C and leaves nothing
def test_a_next_step_is_said(name: str) -> None:
    module = inspect.getsource(sys.modules[function(COMMANDS[name]).__module__])
    assert GUIDES[name].then is not None or "suggest(" in module
