"""What commands print as JSON is what its description says: every key, and no other."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer
from pydantic import TypeAdapter, ValidationError

from flexros.cli.app import app
from flexros.cli.json_output import OUTPUTS

Flexros = Callable[..., Any]
SAMPLE = Path(__file__).parents[2] / "bags" / "sample_circle_dae"
ROOT: Any = typer.main.get_command(app)


def with_json(command: Any, path: str = "") -> set[str]:
    """Return the words of all commands with --json."""
    if hasattr(command, "commands"):
        parts = command.commands.items()
        return {words for name, part in parts for words in with_json(part, f"{path} {name}".strip())}
    return {path} if any("--json" in getattr(one, "opts", ()) for one in command.params) else set()


def check(command: str, text: str) -> Any:
    content = json.loads(text)
    TypeAdapter(OUTPUTS[command]).validate_python(content)
    return content


def test_every_command_with_json_is_described() -> None:
    assert with_json(ROOT) == {*OUTPUTS}


RUN_IN = {
    "compare": "commands/test_compare.py",
    "import": "commands/test_import_log.py",
    "import-urdf": "commands/test_exchange.py",
    "import-mjcf": "commands/test_exchange.py",
    "replay": "commands/test_replay.py",
    "diagnose": "commands/test_diagnose.py",
    "doctor": "commands/test_installation.py",
    "clean": "commands/test_installation.py",
    "identify robot": "commands/identify/test_procedure.py",
    "identify design": "commands/identify/test_procedure.py",
    "identify fit": "commands/identify/test_procedure.py",
    "identify friction": "commands/identify/test_friction.py",
    "identify rigid": "commands/identify/test_rigid.py",
    "identify axis": "commands/identify/test_axis.py",
    "identify kinematics": "commands/identify/test_kinematics.py",
    "demo": "commands/test_demo.py",
    "bench": "../validation/commands/test_bench.py",
    "campaign": "../validation/commands/test_campaign.py",
    "blind score": "../validation/commands/test_blind.py",
}
"""Tests that run a command with --json where this file does not; the fixture `flexros` compares all that they print."""


@pytest.mark.parametrize("command", OUTPUTS)
def test_every_output_is_compared_with_its_description(command: str) -> None:
    source = Path(__file__).parent / RUN_IN.get(command, Path(__file__).name)
    tests = re.sub(r"RUN_IN = {.*?^}", "", source.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    words = r",\s*".join(f'"{word}"' for word in command.split())
    assert re.search(words, tests), f"{source.name} does not run {command}; add a test of its output"
    assert '"--json"' in tests


def test_a_key_that_is_not_described_is_found(flexros: Flexros, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(OUTPUTS, "robots", list[dict[str, int]])
    with pytest.raises(ValidationError, match="integer"):
        flexros("robots", "--json")


def test_a_key_of_a_model_that_is_not_described_is_found() -> None:
    with pytest.raises(ValidationError, match="new"):
        check("learn", '{"max_mm": [], "rms_mm": [], "new": 1}')


@pytest.mark.parametrize(
    "words",
    [
        ("robots",),
        ("robot", "two_mass"),
        ("scenarios",),
        ("analyze", str(SAMPLE)),
        ("analyze", str(SAMPLE), str(SAMPLE)),
        ("benchmark",),
        ("design",),
        ("fastest", "elbow_moves", "--set", "trajectory.time_law={type: time_optimal, points: 51}"),
        ("design", "pole_placement", "--model", "two_mass"),
    ],
    ids=" ".join,
)
def test_output_is_as_described(flexros: Flexros, words: tuple[str, ...]) -> None:
    ended = flexros(*words, "--json")
    assert ended.code == 0, ended.err
    assert check(words[0], ended.out)


def test_files_that_are_written(flexros: Flexros, tmp_path: Path) -> None:
    options = ("--transport", "direct", "--set", "duration=0.05", "--out", str(tmp_path / "log"))
    assert check("run", flexros("run", "circle_pd", *options, "--json").out)["samples"] == 101
    check("learn", flexros("learn", "circle_pd", "--trials", "2", "--json").out)
    check("export", flexros("export", "two_mass", "--to", "json", "--out", str(tmp_path / "x.json"), "--json").out)


@pytest.mark.slow
def test_identification_from_log_to_parameters(flexros: Flexros, tmp_path: Path) -> None:
    log, responses = str(tmp_path / "log"), str(tmp_path / "frf.nc")
    flexros("run", "identify_two_mass", "--transport", "direct", "--out", log)
    check("identify frf", flexros("identify", "frf", log, "--out", responses, "--json").out)
    fit = ("fit", responses, "--model", "two_mass", "--starts", "1", "--out", str(tmp_path / "fit"), "--json")
    check("identify fit", flexros("identify", *fit).out)


@pytest.mark.slow
def test_gap_and_monitor(flexros: Flexros, tmp_path: Path) -> None:
    log = str(tmp_path / "log")
    flexros(
        "run", "diagnosis", "--model", "two_mass", "--set", "diagnosis.length=10", "--transport", "direct", "--out", log
    )
    check("gap", flexros("gap", log, "--model", "two_mass", "--json").out)
    check("monitor", flexros("monitor", log, "--model", "two_mass", "--json").out)
