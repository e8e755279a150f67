"""The page of the endurance test: part by part, resumable, and honest about what went wrong."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from tests.soak import endurance_page
from tests.soak.endurance_page import PARTS, Part, main
from tests.soak.result import Result


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replace the parts by three quick ones: one as it must be, one not, one that breaks off."""
    made: list[str] = []

    def good(folder: Path) -> Result:
        made.append("good")
        result = Result(["what"], notes=["A note."])
        result.add("this")
        return result

    def bad(folder: Path) -> Result:
        made.append("bad")
        result = Result(["what"])
        result.add("that", wrong="a file left")
        return result

    def broken(folder: Path) -> Result:
        raise RuntimeError("the machine is gone")

    parts = {
        name: Part(f"Part {name}", "Text.", run) for name, run in (("good", good), ("bad", bad), ("broken", broken))
    }
    monkeypatch.setattr(endurance_page, "PARTS", parts)
    return made


def run(monkeypatch: pytest.MonkeyPatch, folder: Path, *options: str) -> int:
    words = ["endurance_page", "--out", str(folder), "--work", str(folder / "work"), *options]
    monkeypatch.setattr(sys, "argv", words)
    return main()


def test_page_tells_what_was_tried_and_what_went_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, calls: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, tmp_path) == 1
    text = (tmp_path / "endurance.md").read_text()
    assert "| Part good | 1 | 1 |" in text
    assert "| Part bad | 1 | 0 |" in text
    assert "| that | a file left |" in text
    assert "A note." in text
    assert "| Part broken | not run yet |" in text
    assert "bad: that | a file left" in capsys.readouterr().out


def test_parts_that_are_done_are_not_done_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, calls: list[str]
) -> None:
    run(monkeypatch, tmp_path, "--only", "good")
    assert run(monkeypatch, tmp_path, "--only", "good") == 0
    assert calls == ["good"]
    run(monkeypatch, tmp_path, "--only", "good", "--again")
    assert calls == ["good", "good"]


def test_results_of_another_checkout_stay_on_the_page_and_are_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, calls: list[str]
) -> None:
    run(monkeypatch, tmp_path, "--only", "good", "bad")
    shutil.rmtree(tmp_path / "work")
    assert run(monkeypatch, tmp_path, "--only", "good") == 0
    assert calls == ["good", "bad", "good"]
    assert "| Part bad | 1 | 0 |" in (tmp_path / "endurance.md").read_text()


def test_what_touches_more_than_the_checkout_is_run_by_its_name_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, calls: list[str]
) -> None:
    good = endurance_page.PARTS["good"]
    monkeypatch.setattr(endurance_page, "PARTS", {"good": good, "asked": replace(good, asked=True)})
    run(monkeypatch, tmp_path)
    assert calls == ["good"]
    run(monkeypatch, tmp_path, "--only", "asked")
    assert calls == ["good", "good"]


def test_every_part_says_what_it_is_about() -> None:
    assert all(part.title and part.text for part in PARTS.values())
