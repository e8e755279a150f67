"""The command that measures, without measuring."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexros.validation.commands import bench
from flexros.validation.commands.bench import markdown

Flexros = Callable[..., "object"]


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.validation.commands.bench.importlib.util.find_spec", lambda name: object())


@pytest.mark.usefixtures("peers")
@pytest.mark.parametrize(
    ("stderr", "last"), [("Traceback\nValueError: [odd]\n", "ValueError: [odd]"), ("", "it printed no error")]
)
def test_a_benchmark_that_fails_is_told_in_its_own_words(
    flexros: Flexros, monkeypatch: pytest.MonkeyPatch, stderr: str, last: str
) -> None:
    failed = SimpleNamespace(returncode=1, stdout="", stderr=stderr)
    monkeypatch.setattr(subprocess, "run", lambda *args, **kwargs: failed)
    ended = flexros("bench", "compile", "--json")
    assert (ended.code, ended.err) == (3, f"flexros: benchmark compile ended with code 1: {last}\n")


@pytest.mark.usefixtures("peers")
def test_rows_with_machine_and_versions(flexros: Flexros, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [{"case": "elbow", "ns": 12.5}]
    monkeypatch.setattr(bench, "_measure", lambda name, file: rows)
    content = json.loads(flexros("bench", "compile", "--json").out)
    assert content["results"] == {"compile": rows}
    assert "numpy" in content["machine"]["versions"]


@pytest.mark.usefixtures("peers")
def test_unknown_benchmark_is_refused(flexros: Flexros) -> None:
    ended = flexros("bench", "compil")
    assert ended.code == 2
    assert "unknown benchmark 'compil': did you mean 'compile'?" in ended.err


@pytest.mark.usefixtures("peers")
def test_a_result_without_a_folder_is_refused_before_anything_is_measured(
    flexros: Flexros, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(subprocess, "run", lambda *args, **kwargs: pytest.fail("it measured"))
    ended = flexros("bench", "compile", "--out", str(tmp_path / "no" / "a.md"))
    assert ended.code == 2
    assert "its folder does not exist; make it or give another" in ended.err


def test_page_names_machine_and_versions() -> None:
    described = {"processor": "P", "cores": 2, "versions": {"python": "3.11", "numpy": "2.0"}}
    page = markdown(described, {"compile": [{"what": "step", "value": 1.23456}]})
    assert "- processor: P\n- cores: 2\n- versions: python 3.11, numpy 2.0\n" in page
    assert "## compile\n\n| what | value |\n|---|---|\n| step | 1.235 |\n" in page
