"""Programs that write the pages of results: arguments are read before any work begins."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parents[2] / "docs" / "results" / "programs"
STARTED = sorted(file for file in PROGRAMS.rglob("*.py") if "__main__" in file.read_text(encoding="utf-8"))


def run(file: Path, argument: str, monkeypatch: pytest.MonkeyPatch) -> object:
    pytest.importorskip("mujoco", reason="some programs simulate with MuJoCo")
    monkeypatch.setattr(sys, "argv", [str(file), argument])
    monkeypatch.setattr(sys, "path", [str(file.parent), str(PROGRAMS), *sys.path])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(file), run_name="__main__")
    return ended.value.code


@pytest.mark.parametrize("file", STARTED, ids=lambda file: file.stem)
def test_a_program_explains_its_arguments(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(file, "--help", monkeypatch) == 0
    assert "usage:" in capsys.readouterr().out


@pytest.mark.parametrize("file", STARTED, ids=lambda file: file.stem)
def test_a_program_refuses_an_option_that_it_does_not_have(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(file, "--unknown", monkeypatch) == 2
