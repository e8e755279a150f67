"""Doctor and clean as a user sees them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from flexros.cli.json_output import OUTPUTS
from flexros.installation import doctor as checks
from flexros.installation.finding import Finding

Flexros = Callable[..., Any]


def found(state: str) -> Callable[..., tuple[Finding, ...]]:
    finding = Finding("cache", state, "what was found", "" if state == "ok" else "what to do", {"size_bytes": 1})  # type: ignore[arg-type]
    return lambda _environment: (finding,)


@pytest.mark.parametrize(("state", "code"), [("ok", 0), ("limited", 0), ("broken", 1)])
def test_exit_code_of_the_doctor(flexros: Flexros, monkeypatch: pytest.MonkeyPatch, state: str, code: int) -> None:
    monkeypatch.setattr(checks, "examine", found(state))
    ended = flexros("doctor")
    assert ended.code == code
    assert ("-> what to do" in ended.out) == (state != "ok")


def test_findings_as_json(flexros: Flexros, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "examine", found("broken"))
    content = json.loads(flexros("doctor", "--json").out)
    TypeAdapter(OUTPUTS["doctor"]).validate_python(content)
    assert content["healthy"] is False
    assert content["findings"][0]["facts"] == {"size_bytes": 1}


def test_clean_shows_first_and_removes_on_demand(
    flexros: Flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("FLEXROS_CACHE", "off")
    old, new = (Path(tempfile.mkdtemp(prefix="flexros_")) for _ in range(2))
    results = tmp_path / "flexros_circle"  # flexros run ... --out /tmp/flexros_circle
    results.mkdir()
    for folder in (old, new, results):
        (folder / "log").write_bytes(bytes(250_000))
    for path in (old / "log", old, results / "log", results):
        os.utime(path, (1e9, 1e9))
    shown = flexros("clean").out
    assert "0.2 MB" in shown
    assert "in use, kept" in shown
    assert old.exists()
    content = json.loads(flexros("clean", "--yes", "--json").out)
    TypeAdapter(OUTPUTS["clean"]).validate_python(content)
    assert content["removed"] == [str(old)]
    assert content["freed_bytes"] == 250_000
    assert not old.exists()
    assert new.exists()
    assert results.exists()
