"""`flexros blind make|run|score`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.gap.result import DiagnosisResult
from flexros.validation.blind import diagnose_case as blind_run
from flexros.validation.commands.blind import part_of
from tests.cli.conftest import Ended
from tests.validation.blind.cases import diagnosis

SMALL = ("--per-size", "0", "--nulls", "2", "--unknowns", "0", "--pairs", "0", "--robots", "four_mass_linear=1")


class Answered:
    """Stand-in for the result of a diagnosis."""

    diagnosis = diagnosis("no_gap")


@pytest.mark.slow
def test_make_run_and_score(flexros: Callable[..., Ended], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def diagnosed(folder: Path, case: object) -> DiagnosisResult:
        return Answered()  # type: ignore[return-value]

    monkeypatch.setattr(blind_run, "diagnosed", diagnosed)
    logs, truth = str(tmp_path / "logs"), str(tmp_path / "truth")
    made = flexros("blind", "make", "--out", logs, "--truth", truth, "--seed", "5", "--duration", "8", *SMALL)
    assert made.code == 0, made.err
    assert "2 cases in" in made.out
    assert "1 cases diagnosed, 1 of 2 are left" in flexros("blind", "run", logs, "--cases", "0:1").out
    assert "1 cases diagnosed, 0 of 2 are left" in flexros("blind", "run", logs, "--no-keep-logs").out
    figures = json.loads(flexros("blind", "score", logs, "--truth", truth, "--json").out)
    assert figures["all"]["false_alarms"] == pytest.approx(
        {"hits": 0, "cases": 2, "low": 0.0, "high": 0.6576}, abs=1e-3
    )
    assert "false alarms of logs without deviation" in flexros("blind", "score", logs, "--truth", truth).out


def test_truths_within_the_logs_are_refused(flexros: Callable[..., Ended], tmp_path: Path) -> None:
    ended = flexros("blind", "make", "--out", str(tmp_path), "--truth", str(tmp_path / "truth"), "--seed", "1")
    assert ended.code == 2
    assert "is in the folder of the logs" in ended.err


def test_negative_seed_is_refused(flexros: Callable[..., Ended], tmp_path: Path) -> None:
    places = ("--out", str(tmp_path / "logs"), "--truth", str(tmp_path / "truth"))
    assert "--seed is -1, allowed are 0 and above" in flexros("blind", "make", *places, "--seed", "-1").err


def test_share_that_is_no_number_is_refused(flexros: Callable[..., Ended], tmp_path: Path) -> None:
    places = ("--out", str(tmp_path / "logs"), "--truth", str(tmp_path / "truth"), "--seed", "1")
    ended = flexros("blind", "make", *places, "--robots", "e12=much")
    assert ended.code == 2
    assert "--robots is 'e12=much', but must be NAME=SHARE" in ended.err


@pytest.mark.parametrize("text", ["5", "a:b", "-1:3"])
def test_part_of_another_form_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=f"--cases is '{text}', but must be FIRST:END"):
        part_of(range(10), text)


def test_part_is_first_to_end() -> None:
    assert part_of(range(10), "2:4") == [2, 3]
    assert part_of(range(3), "") == [0, 1, 2]
    with pytest.raises(InputError, match="holds none of the 10 cases"):
        part_of(range(10), "20:30")
