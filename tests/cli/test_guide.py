"""Help by job with examples that parse, and what to do next."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from flexros.cli.app import COMMANDS, app
from flexros.cli.commands.identify.procedure import COMMANDS as IDENTIFY
from flexros.cli.guide import GUIDES, JOBS, OTHER, Guide, guide_of
from flexros.robot import library

Flexros = Callable[..., Any]
ROOT: Any = typer.main.get_command(app)
SAYS_IT_ITSELF = {"run", "import", "diagnose", "identify frf", "view"}
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


def test_next_step_after_a_gap_names_log_and_model() -> None:
    given = {"bag": "a b", "model": "e12", "patch": None}
    then = GUIDES["gap"].then
    assert then is not None
    assert then(given, 1).startswith("flexros diagnose 'a b' --model e12 --out diagnosis")


@pytest.mark.parametrize(
    ("source", "options"),
    [
        ("", "--to urdf --out repaired.urdf"),
        ("panda.urdf", "--to urdf --base panda.urdf --out repaired.urdf"),
        ("wx250s.xml", "--to mjcf --base wx250s.xml --out repaired.xml"),
    ],
)
def test_next_step_after_a_repaired_gap_is_an_export_into_the_imported_file(
    source: str, options: str, tmp_path: Path
) -> None:
    text = Path(library.__path__[0], "elbow.yaml").read_text(encoding="utf-8")
    text = re.sub("(?m)^defaults: .*$", f'defaults: {{source: "{source}"}}', text)
    (tmp_path / "arm.yaml").write_text(text, encoding="utf-8")
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: arm.yaml\neffects: []\n", encoding="utf-8")
    then = GUIDES["gap"].then
    assert then is not None
    assert f"flexros export {patch} {options}  " in then({"bag": "a", "model": "e12", "patch": patch}, 0)
