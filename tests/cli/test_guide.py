"""Help by job with examples that parse, and what to do next."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import typer

from flexros.cli.app import COMMANDS, app
from flexros.cli.commands.identify.procedure import COMMANDS as IDENTIFY
from flexros.cli.guide import GUIDES, JOBS, OTHER, Guide, guide_of

Flexros = Callable[..., Any]
ROOT: Any = typer.main.get_command(app)
SAYS_IT_ITSELF = {"run", "import", "diagnose", "gap", "identify frf", "view"}
"""Commands whose next step depends on their result."""


def examples() -> Iterator[tuple[str, str]]:
    for command, guide in GUIDES.items():
        for example in guide.examples:
            yield command, example


def test_every_command_has_a_guide() -> None:
    known = {*COMMANDS, *(f"identify {word}" for word in IDENTIFY)}
    assert known - set(GUIDES) == set()
    assert {guide.job for guide in GUIDES.values()} <= set(JOBS) - {OTHER}


@pytest.mark.parametrize("command", sorted({*COMMANDS, *(f"identify {word}" for word in IDENTIFY)}))
def test_every_command_says_what_comes_next(command: str) -> None:
    assert (GUIDES[command].then is None) == (command in SAYS_IT_ITSELF)


@pytest.mark.parametrize(("command", "example"), list(examples()))
def test_examples_are_commands_with_options_that_exist(command: str, example: str) -> None:
    words = shlex.split(example, comments=True)
    named = command.split()
    assert words[: 1 + len(named)] == ["flexros", *named]
    target = ROOT
    for word in named:
        target = target.commands[word]
    target.make_context(command, words[1 + len(named) :], resilient_parsing=False).close()


def test_help_lists_commands_by_job_in_short_lines(flexros: Flexros) -> None:
    text = flexros("--help").out
    places = [text.index(f"\n{job}:\n") for job in JOBS if job != OTHER]
    assert places == sorted(places)
    listed = text[places[0] : text.index("Examples:")]
    assert "..." not in listed
    assert max(map(len, listed.splitlines())) <= 80


def test_help_of_a_command_ends_with_its_examples(flexros: Flexros) -> None:
    assert flexros("gap", "--help").out.rstrip().endswith("flexros gap other --model e12 --patch diagnosis/patch.yaml")


def test_an_unknown_command_is_described_by_its_docstring() -> None:
    assert guide_of("new", "Do it. And more.\n\nMore.") == Guide(OTHER, "Do it", ())


def test_next_step_is_on_stderr_and_not_beside_json(flexros: Flexros) -> None:
    ended = flexros("robots")
    assert ended.err == "Next: flexros robot e12 --q 0,0.3,0\n"
    assert flexros("robots", "--json").err == ""
