"""Errors of commands: one sentence and the exit code of the contract."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import pytest
import typer

from flexros.cli.app import reported
from flexros.errors import InputError, RunError

Flexros = Callable[..., "object"]


def end_of(error: BaseException) -> int:
    def command() -> None:
        raise error

    with pytest.raises(SystemExit) as ended:
        reported(command)()
    return int(ended.value.code or 0)


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (InputError("no robot"), 2, "flexros: no robot\n"),
        (RunError("aborted"), 3, "flexros: aborted\n"),
        (KeyboardInterrupt(), 130, "flexros: interrupted by Ctrl-C\n"),
        (FileExistsError(17, "File exists", "bags"), 2, "flexros: 'bags': File exists; give a path that can be used\n"),
        (OSError(28, "No space left on device"), 2, "flexros: No space left on device\n"),
    ],
)
def test_an_expected_error_is_one_sentence(
    capsys: pytest.CaptureFixture[str], error: BaseException, code: int, text: str
) -> None:
    assert end_of(error) == code
    assert capsys.readouterr().err == text


@pytest.mark.parametrize(
    ("argument", "prefix"), [("out", "--out: "), ("model", "--model: "), ("name", ""), ("elsewhere", ""), ("", "")]
)
def test_an_error_that_names_an_argument_shows_its_option(
    capsys: pytest.CaptureFixture[str], argument: str, prefix: str
) -> None:
    def command(
        model: Annotated[str, typer.Option("--model")],
        name: str = typer.Argument(""),
        out: str = typer.Option("", "--out", help="Folder."),
    ) -> None:
        raise InputError("cannot be used", argument)

    with pytest.raises(SystemExit):
        reported(command)("", "", "")
    assert capsys.readouterr().err == f"flexros: {prefix}cannot be used\n"


@pytest.mark.parametrize("error", [ValueError("odd"), AssertionError("odd"), RuntimeError("odd")])
def test_a_fault_of_ours_has_a_traceback_and_a_code_of_its_own(
    capsys: pytest.CaptureFixture[str], error: Exception
) -> None:
    assert end_of(error) == 70
    printed = capsys.readouterr().err
    assert "Traceback" in printed
    assert f"{type(error).__name__}: odd" in printed
    assert printed.endswith("flexros: internal error, please report it with the lines above\n")


def test_a_file_where_the_folder_of_logs_should_be(
    flexros: Flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bags").write_text("data")
    ended = flexros("run", "circle_pd", "--transport", "direct")
    assert ended.code == 2
    assert "'bags': File exists" in ended.err
    assert len(ended.told) == 1


def test_a_reader_that_goes_away_is_no_gap_and_no_fault() -> None:
    program = "import os; r, w = os.pipe(); os.close(r); os.dup2(w, 1); from flexros.cli import main; main(['robots'])"
    done = subprocess.run([sys.executable, "-c", program], stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_help_lists_the_exit_codes(flexros: Flexros) -> None:
    text = " ".join(flexros("--help").out.split())
    for code in (
        "0 done",
        "1 a gap was found",
        "2 bad input",
        "3 run aborted",
        "70 internal error",
        "130 Ctrl-C",
    ):
        assert code in text
